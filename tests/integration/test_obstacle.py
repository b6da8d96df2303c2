"""Scenario obstacle: library and MuJoCo plant in one process, measured at what can touch."""

import dataclasses

import numpy as np
import pytest

from lexstack.transition import Phase
from lexstack_config.resolved import load_scenario
from lexstack_config.scenario import EventConfig
from lexstack_experiments.loop import Loop
from lexstack_sim.obstacles import Clearance
from support.scenario import CONFIG

PASSING, PAST = 6.5, 21.0  # s, the second and the third switch


def scenario(**values):
    """Return the scenario with some of its values replaced."""
    resolved = load_scenario(CONFIG / "scenarios" / "obstacle.yaml")
    return dataclasses.replace(resolved, scenario=dataclasses.replace(resolved.scenario, **values))


def clearance_of(loop):
    """Return the distance of each robot to each obstacle at every tick, (T, 2, 3), m."""
    team = loop.parts.team
    measure = Clearance(loop.plant.world, team)
    return np.array([measure.at(state.q, state.stamp) for state in loop.record.states])


@pytest.fixture(scope="module")
def run():
    """Run the whole scenario once."""
    loop = Loop(scenario())
    loop.run()
    return loop


@pytest.fixture(scope="module")
def clearance(run):
    """Return the distances at every tick."""
    return clearance_of(run)


@pytest.fixture(scope="module")
def ee_error(run):
    """Return the distance of each tool from its reference at every tick, (T, 2), mm."""
    team, record = run.parts.team, run.record
    return 1e3 * np.array(
        [
            [
                np.linalg.norm(tool.position - goal.position)
                for tool, goal in zip(team.tools(state.q), references.ee, strict=True)
            ]
            for state, references in zip(record.states, record.references, strict=True)
        ]
    )


def test_nobody_is_touched(run, clearance):
    assert run.plant.counters.contact == 0
    assert clearance.min() >= 0.04, "10 mm of the margin are the spheres' own"


def test_every_ball_comes_near(run, clearance):
    hanging, rolling, flying = clearance[:, 0, 0], clearance[:, :, 1], clearance[:, 1, 2]
    assert hanging.min() < 0.1
    assert (rolling.min(axis=0) < 0.15).all()
    assert flying.min() < 0.1


def test_the_switch_comes_while_the_ball_passes(run, clearance):
    beside = clearance[round(100 * PASSING) : round(100 * PASSING) + 100, 0, 1]
    assert (beside < 0.2).all()
    commands = run.record.commands
    adopted = [c.transition.to_stack for c in commands if c.transition.phase is Phase.ADOPTING]
    assert adopted == ["avoid", "avoid_base", "avoid"]


def test_the_command_keeps_its_limits(run):
    commands, team = run.record.commands, run.parts.team
    chi = np.array([command.chi for command in commands])
    ratio = np.abs(np.diff(chi, axis=0)) / (0.01 * team.limits.acceleration)
    assert ratio.max() <= 1.0 + 1e-9
    assert not any(command.fallback for command in commands)
    assert run.plant.counters.over_acceleration == run.plant.counters.over_velocity == 0


def test_the_distances_are_never_given_up(run):
    assert max(command.slacks[0] for command in run.record.commands[200:]) <= 1e-6


def test_the_tools_stay_and_arrive(run, ee_error):
    assert ee_error[: round(100 * PASSING)].max() <= 1.0, "before the switch"
    assert ee_error[: round(100 * PAST)].max() <= 15.0, "through the switch beside the ball"
    assert ee_error[round(100 * PAST) - 50 : round(100 * PAST)].max() <= 0.1
    assert ee_error[-50:].max() <= 0.1, "past the ball that hangs"


def test_the_bases_reach_their_targets(run):
    state, team = run.record.states[round(100 * PAST)], run.parts.team
    for name, goal in run.resolved.scenario.events[1].base_target.items():
        part = team.slices[team.index(name)]
        assert np.linalg.norm(state.q[part][:2] - goal[:2]) <= 5e-3


def test_a_switch_that_comes_late_comes_in_time():
    """Distances hold from the trigger on; a blend of 1 s into them would touch the ball."""
    late = EventConfig(6.0, switch="avoid")
    loop = Loop(scenario(events=(late,), duration=9.0))
    loop.run()
    assert loop.plant.counters.contact == 0
    assert clearance_of(loop).min() > 0.05


def test_the_same_without_distances_is_run_over():
    loop = Loop(scenario(events=(), duration=8.0))
    loop.run()
    assert loop.plant.counters.contact > 100
    assert clearance_of(loop).min() < -0.01
