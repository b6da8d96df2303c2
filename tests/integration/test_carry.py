"""Two robots carry one object through a switch: library and MuJoCo plant in one process."""

import numpy as np
import pytest

from lexstack.tasks import other_end, pose_error
from lexstack.transition import Phase
from lexstack_config.parts import build_references
from lexstack_config.resolved import load_scenario
from lexstack_experiments.loop import Loop, targets_of
from lexstack_experiments.runs import analysed
from support.scenario import CONFIG

HOLD = 6.0  # s, the switch to carry
SWITCH = 9.0  # s, the switch from carry to carry_base
BLEND = 2.0  # s


@pytest.fixture(scope="module")
def run():
    """Run the whole scenario once."""
    loop = Loop(load_scenario(CONFIG / "scenarios" / "carry.yaml"))
    loop.run()
    return loop


@pytest.fixture(scope="module")
def errors(run):
    """Return time [s], |e_p| of the object [m], |e_R| [rad] and robot A's |e_p| [m] per tick."""
    team = run.parts.team
    schedule = build_references(run.resolved, team)
    for event in run.resolved.scenario.events:
        for target in targets_of(event, team):
            schedule.add(target)
    rows = []
    for state in run.record.states:
        references, tools = schedule.at(state.stamp), team.tools(state.q)
        relative = pose_error(tools[1], other_end(tools[0], *references.ee))
        own = pose_error(tools[0], references.ee[0])
        norms = [np.linalg.norm(part) for part in (relative[:3], relative[3:], own[:3])]
        rows.append((state.stamp, *norms))
    return np.array(rows)


def peak(errors, start, end):
    """Return the largest errors of a time."""
    time = errors[:, 0]
    return errors[(time >= start) & (time < end), 1:].max(axis=0)


def test_the_hold_begins_where_the_tools_are(errors):
    linear, angular, _ = peak(errors, HOLD - 0.05, HOLD)
    assert linear <= 0.2e-3
    assert angular <= 0.5e-3


def test_the_object_stays_in_both_hands_through_the_switch(errors):
    linear, angular, _ = peak(errors, SWITCH, SWITCH + BLEND)
    assert linear <= 2e-3
    assert angular <= 2e-3


def test_the_object_stays_in_both_hands_from_the_hold_to_the_end(errors):
    linear, angular, _ = peak(errors, HOLD, np.inf)
    assert linear <= 2e-3
    assert angular <= 2e-3


def test_the_figures_of_the_run_say_so(run, errors):
    """As ``metrics.json`` states it, phase by phase."""
    phases = {phase.stack: phase for phase in analysed(run).metrics.phases}
    for stack, start, end in (("carry", HOLD, SWITCH), ("carry_base", SWITCH, np.inf)):
        linear, angular, _ = 1e3 * peak(errors, start, end)
        assert phases[stack].relative_peak_error_mm["robot_a"] == pytest.approx(linear)
        assert phases[stack].relative_peak_error_mrad["robot_a"] == pytest.approx(angular)
        assert phases[stack].relative_error_mm["robot_a"] <= 0.1
    assert phases["posture"].relative_error_mm is None


def test_the_object_is_really_carried(run):
    """It goes 0.4 m at least, and all of it arrives."""
    team = run.parts.team
    states = {time: run.record.states[round(100 * time)] for time in (HOLD, SWITCH)}
    before, after = (team.tools(states[time].q)[1].position for time in (HOLD, SWITCH))
    assert np.linalg.norm(after - before) > 0.3
    assert np.linalg.norm(team.tools(run.record.states[-1].q)[1].position - after) > 0.4


def test_the_object_and_the_bases_arrive(run, errors):
    assert errors[-1, 3] <= 1e-3
    assert errors[-1, 1] <= 0.1e-3
    team, state = run.parts.team, run.record.states[-1]
    for name, goal in run.resolved.scenario.events[-1].base_target.items():
        part = team.slices[team.index(name)]
        assert np.linalg.norm(state.q[part][:2] - goal[:2]) <= 0.03  # exp(-0.4 t) after 11 s


def test_all_switches_are_adopted_within_the_limits(run):
    commands = run.record.commands
    adopted = [c.transition.to_stack for c in commands if c.transition.phase is Phase.ADOPTING]
    assert adopted == ["posture", "carry", "carry_base"]
    assert not [command.fallback for command in commands if command.fallback]
    assert not any(vars_of(run.plant.counters))


def vars_of(counters):
    """Return the plant's counters as numbers."""
    return [getattr(counters, name) for name in counters.__slots__]
