"""The paper's task sequence in one process: library and MuJoCo plant, without ROS."""

import numpy as np
import pytest

from lexstack.tasks import pose_error
from lexstack.transition import Phase
from lexstack_config.parts import build_references
from lexstack_experiments.loop import Loop, targets_of
from support.scenario import resolved


@pytest.fixture(scope="module")
def run():
    """Run the whole scenario once."""
    loop = Loop(resolved())
    loop.run()
    return loop


def ee_errors(run, second):
    """Return both tools' position errors [m] at a time [s], measured against the references."""
    schedule = build_references(run.resolved, run.parts.team)
    for event in run.resolved.scenario.events:
        for target in targets_of(event, run.parts.team):
            schedule.add(target)
    references = schedule.at(second)
    state = run.record.states[round(second * run.resolved.scenario.rate) - 1]
    tools = run.parts.team.tools(state.q)
    return [
        np.linalg.norm(pose_error(tool, goal)[:3])
        for tool, goal in zip(tools, references.ee, strict=True)
    ]


def test_three_switches_reach_adoption(run):
    adopted = [
        c.transition.to_stack for c in run.record.commands if c.transition.phase is Phase.ADOPTING
    ]
    assert adopted == ["reach_base", "posture_mid_range", "track"]


def test_the_command_keeps_its_limits(run):
    chi = np.array([command.chi for command in run.record.commands])
    steps = np.diff(chi, axis=0, prepend=np.zeros((1, run.parts.team.n)))
    limits = run.parts.team.limits
    assert np.abs(steps / (run.parts.dt * limits.acceleration)).max() <= 1.0001
    assert (np.abs(chi) <= limits.velocity).all()
    assert sum(command.bounds.empty for command in run.record.commands) == 0
    assert not [c.fallback for c in run.record.commands if c.fallback]


def test_after_a_the_tools_and_bases_are_in_place(run):
    assert max(ee_errors(run, 9.0)) <= 2e-3
    state = run.record.states[899]
    goals = run.resolved.scenario.base_target
    for name, part in zip(run.parts.team.names, run.parts.team.slices, strict=True):
        assert np.linalg.norm(state.q[part][:2] - goals[name][:2]) <= 5e-3


def test_after_c_both_tools_are_at_one_place(run):
    assert max(ee_errors(run, 26.0)) <= 1e-3


def test_the_plant_had_no_complaint(run):
    counters = run.plant.counters
    assert counters.over_velocity == counters.over_acceleration == counters.contact == 0
    assert counters.clamped == 0
