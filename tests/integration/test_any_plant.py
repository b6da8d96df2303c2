"""Robots of any URDF in the simulation: they hold still, reach a target, and switch smoothly."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from lexstack.robots import to_quaternion
from lexstack.transition import Phase
from lexstack_config.parts import Parts, build_team
from lexstack_config.resolved import ResolvedScenario, load_robot
from lexstack_config.scenario import EventConfig, PlacementConfig, PoseConfig
from lexstack_experiments.loop import Loop
from lexstack_sim.plant import Plant
from support.scenario import CONFIG, resolved

TWELVE = (
    *("panda", "ur5", "ur10", "xarm7", "so101", "z1", "kinova"),
    *("tiago", "tiago_dual", "baxter", "pr2", "g1"),
)
SEEDS = {"tiago": 6}
"""Of the targets, 5 for the others: there TIAGo's hand would have to go through its own base."""
REACHED = 5.0  # s after which the target is reached, and the switch begins
STACKS = ("track", "posture")


def scenario_of(name: str, rng: np.random.Generator) -> ResolvedScenario:
    """Return a robot that is to go to a pose near its home and then to change its stack."""
    base = resolved()
    place = PlacementConfig(name, (0.3, -0.2, 0.5), z=0.1)
    scenario = dataclasses.replace(
        base.scenario, robots={"robot": place}, ee_target={}, base_target={}, events=()
    )
    stacks = {key: base.stacks[key] for key in STACKS}
    robots = {name: load_robot(CONFIG / "robots" / f"{name}.yaml")}
    found = ResolvedScenario(scenario, robots, stacks)
    team = build_team(found)
    (robot,), limits = team.robots, team.limits
    nearby, arm = robot.home(place.base), robot.arm
    span = np.where(robot.prismatic, 0.02, 0.15) * rng.choice([-1.0, 1.0], robot.n)
    lower, upper = limits.position_lower[arm] + 1e-3, limits.position_upper[arm] - 1e-3
    nearby[robot.arm_q] = np.clip(nearby[robot.arm_q] + span[arm], lower, upper)
    if robot.has_base and not robot.differential:
        nearby[robot.base_q] += span[robot.base]
    pose = robot.tool(nearby)[0]
    quaternion = tuple(to_quaternion(pose.rotation).tolist())
    target = PoseConfig(tuple(pose.position.tolist()), quaternion)
    event = EventConfig(at=REACHED, switch="posture", duration=1.0)
    scenario = dataclasses.replace(scenario, ee_target={"robot": target}, events=(event,))
    return dataclasses.replace(found, scenario=scenario)


@pytest.mark.parametrize("name", TWELVE)
def test_a_robot_reaches_a_pose_and_switches_smoothly_within_its_limits(name):
    scenario = scenario_of(name, np.random.default_rng(SEEDS.get(name, 5)))
    loop = Loop(scenario)
    plant, team = loop.plant, loop.parts.team
    (robot,), limits = team.robots, team.limits
    goal = scenario.scenario.ee_target["robot"].position
    start = plant.state()
    assert np.linalg.norm(robot.tool(start.q)[0].position - goal) > 0.01  # there is a way to go
    commands, phases = [start.command], []
    for tick in range(700):
        if tick == round(REACHED / team.dt):
            reached = plant.state()
        command = loop.step()
        commands.append(command.chi)
        phases.append(command.transition.phase)
    assert np.linalg.norm(robot.tool(reached.q)[0].position - goal) < 1e-3
    assert np.abs(reached.v[~np.array(robot.prismatic)]).max() < 2e-3
    assert Phase.BLENDING in phases
    assert command.stack == "posture"
    change = np.diff(commands, axis=0) / team.dt
    assert (np.abs(commands) <= limits.velocity * (1.0 + 1e-9)).all()
    assert (np.abs(change) <= limits.acceleration * (1.0 + 1e-9)).all()
    state = plant.state()
    assert np.linalg.norm(robot.tool(state.q)[0].position - goal) < 1e-3
    assert plant.counters.missing == plant.counters.clamped == 0
    assert (np.abs(state.q - state.q_star) < 0.02).all()


@pytest.mark.parametrize("name", TWELVE)
def test_a_robot_holds_still_where_it_starts(name):
    scenario = scenario_of(name, np.random.default_rng(SEEDS.get(name, 5)))
    plant = Plant(scenario, Parts.of(scenario).team)
    start, still = plant.state(), np.zeros(plant.team.n)
    for _ in range(100):
        state = plant.step(still)
    assert np.abs(state.q - start.q).max() < 1e-4
    assert np.abs(state.v).max() < 1e-4
    assert plant.contacts == 0
