"""A differential base on the plans of the MPC: the controller follows v and w, and it parks."""

from functools import cache

import numpy as np
import pytest

import lexstack
from lexstack_config.resolved import load_robot, load_scenario
from lexstack_experiments.ideal import IdealPlant
from support.differential import driven
from support.planned_loop import PlannedLoop
from support.scenario import CONFIG


@cache
def resolved():
    return load_scenario(CONFIG / "scenarios/drive.yaml")


@pytest.mark.parametrize("ideal", [True, False])
def test_tiago_reaches_and_parks_on_the_plans_of_the_mpc(ideal):
    made = PlannedLoop(resolved())
    if ideal:
        made.plant = IdealPlant(made.resolved, made.parts.team)
    record = made.run()
    team = made.parts.team
    progress = made.progress("fetch")
    assert progress[-1].sequence.done
    assert all(each.plan.solved for each in progress)
    done = round(progress[-1].plan.stamp * 100.0)
    x, y, yaw = record.states[done].q[:3]
    assert np.hypot(x, y) < 0.01
    assert abs(yaw) < 0.02
    chi = np.array([command.chi for command in record.commands])
    limits = team.limits
    assert (np.abs(chi) <= limits.velocity + 1e-9).all()
    assert (np.abs(np.diff(chi, axis=0)) <= 0.01 * limits.acceleration + 1e-9).all()
    if ideal:
        # Once the blend is over, the command of a tick is the plan of the tick.
        plans = {round(each.plan.stamp * 100.0): each.plan for each in progress}
        for tick in range(210, done):
            plan = plans[tick - tick % 5]
            np.testing.assert_allclose(chi[tick], plan.sample(0.01 * (tick + 1))[1], atol=1e-9)


def two_arms(name):
    """Return a robot with two arms that drives; of ``tiago_dual`` the wheels are added."""
    if name == "tiago_dual":
        return driven(name)
    return lexstack.RobotModel("robot", load_robot(CONFIG / "robots" / f"{name}.yaml"))


@pytest.mark.parametrize("name", ["tiago_dual", "pr2"])
def test_a_robot_with_two_arms_hands_over_on_its_way(name):
    """Left tool, then right tool, both out of reach from where it stands; then it parks."""
    robot = two_arms(name)
    team = lexstack.Team((robot,), dt=0.05)
    state = team.at_rest(team.home())
    place = {
        side: robot.at(state.q, robot.frame(side))[0].position + np.array([1.2, 0.3, 0.05])
        for side in ("left", "right")
    }
    tasks = (
        lexstack.SequenceTask("give", "ee_position", (tuple(place["left"]),), frame="left"),
        lexstack.SequenceTask("take", "ee_position", (tuple(place["right"]),), frame="right"),
        lexstack.SequenceTask("park", "base_pose", ((0.0, 0.0, 0.0),), 0.5, 0.8, tolerance=0.01),
    )
    runner = lexstack.SequenceRunner(team, 0, lexstack.DEFAULT_HTMPC)
    runner.begin(tasks, lexstack.HT_ARCH, state)
    nearest = {"left": np.inf, "right": np.inf}
    while not (progress := runner.step(state)).sequence.done and state.stamp < 30.0:
        assert progress.plan.solved
        for side, goal in place.items():
            apart = np.linalg.norm(robot.at(state.q, robot.frame(side))[0].position - goal)
            nearest[side] = min(nearest[side], apart)
        q, v, _ = progress.plan.sample(state.stamp + team.dt)
        tick = state.tick + 1
        state = lexstack.RobotState(tick, tick * team.dt, q, v, q, v)
    assert progress.sequence.done
    assert max(nearest.values()) < 0.02
    assert np.hypot(*state.q[:2]) < 0.01


def test_arm_and_base_work_apart_on_a_differential_base():
    robot = lexstack.RobotModel("robot", load_robot(CONFIG / "robots/tiago.yaml"))
    team = lexstack.Team((robot,), dt=0.05)
    state = team.at_rest(team.home())
    home = robot.tool(state.q)[0].position
    tasks = (
        lexstack.SequenceTask("park", "base_pose", ((0.5, 0.6, 0.4),), 0.5, 0.8, tolerance=0.01),
        lexstack.SequenceTask("lift", "ee_position", ((1.0, 0.75, home[2] + 0.1),)),
    )
    runner = lexstack.SequenceRunner(team, 0, lexstack.DEFAULT_HTMPC)
    runner.begin(tasks, lexstack.ST_ARCH, state)
    while not (progress := runner.step(state)).sequence.done and state.stamp < 20.0:
        resting = slice(2, None) if progress.sequence.first == 0 else slice(0, 2)
        if progress.sequence.first == 0 or np.abs(state.v[:2]).max() < 1e-9:
            np.testing.assert_allclose(progress.plan.v[:, resting], 0.0, atol=1e-9)
        q, v, _ = progress.plan.sample(state.stamp + team.dt)
        tick = state.tick + 1
        state = lexstack.RobotState(tick, tick * team.dt, q, v, q, v)
    assert progress.sequence.done
