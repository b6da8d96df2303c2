"""Trajectories by topic through all processes: controller, solver, bag and replay agree in bits."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.figures.series import measure
from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import REPLAYERS, Question
from lexstack_bag.run.reader import read_run
from lexstack_config.resolved import load_scenario
from lexstack_config.scenario import EventConfig
from lexstack_config.trajectories import PathConfig, PostureWayConfig, TwistEventConfig, WayConfig
from lexstack_testing.played_run import together
from support.runs import read, short_scenario
from support.scenario import CONFIG, home

pytestmark = pytest.mark.system
SETTLED = 160  # ticks: the trajectory begins at 1 s, and is led onto for 0.5 s
DOWN = (1.0, 0.0, 0.0, 0.0)


def play(resolved, folder):
    with together(resolved, folder) as run:
        run.play()
        assert run.end() == []
    return read_run(folder)


@pytest.fixture(scope="module")
def eight(tmp_path_factory):
    """Return the run of the scenario with the figure of eight, and its folder."""
    folder = tmp_path_factory.mktemp("eight")
    resolved = load_scenario(CONFIG / "scenarios" / "figure-of-eight.yaml", CONFIG)
    return play(resolved, folder), folder


def everything():
    """Return a run of 5 s with every kind of reference, and two switches in the middle of them."""
    q = home()[3:10].tolist()
    elbow = WayConfig((0.5, 2.0), ((-0.1, 0.1, 1.1), (-0.1, -0.1, 1.1)), (DOWN,), "panda_link4")
    way = WayConfig((1.0, 2.0, 3.0), ((0.4, 0, 0.9), (0.4, 0.2, 0.9), (0.4, 0, 0.9)), (DOWN,))
    events = (
        EventConfig(0.3, ee_trajectory={"robot_a": way}),
        EventConfig(0.4, ee_twist={"robot_b": TwistEventConfig(2.0, (0.05, 0, 0), (0, 0, 0.2))}),
        EventConfig(
            0.5,
            ee_trajectory={"robot_b": elbow},
            base_path={"robot_a": PathConfig(((0, 0, 0), (0.2, 0, 0.1), (0.4, 0.1, 0.2)))},
            posture_trajectory={"robot_a": PostureWayConfig((1.0, 3.0), (tuple(q), tuple(q)))},
        ),
        EventConfig(1.0, "reach_base"),
        EventConfig(3.0, "posture"),
    )
    return short_scenario(events=events, duration=5.0, base_target={})


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mixed")
    return play(everything(), folder), folder


def test_the_figure_of_eight_is_tracked_within_a_millimetre_through_a_transition(eight):
    run, _ = eight
    series = measure(run)
    assert series.ee_error[SETTLED:].max() < 1.0  # mm
    moved = np.ptp(series.ee_target[SETTLED:, 0], axis=0)
    np.testing.assert_allclose(moved, [0.0, 0.3, 0.2], atol=2e-3)
    speed = np.linalg.norm(np.diff(series.ee_target[SETTLED:, 0], axis=0), axis=1) * 100.0
    assert 0.2 < speed.max() < 0.22  # m/s
    blended = run.transition.stamp[run.transition.source == "robot_b"]
    assert (blended[0], blended[-1]) == pytest.approx((9.0, 10.0))
    assert set(run.transition.reason.tolist()) == {""}
    assert run.chi["robot_a"].stack[-1] == "posture"


@pytest.mark.parametrize("name", ["eight", "mixed"])
def test_the_solver_has_the_same_references_and_replay_repeats_every_bit(name, request):
    run, _ = request.getfixturevalue(name)
    of_a = dict(zip(run.chi["robot_a"].tick, run.chi["robot_a"].references, strict=True))
    solver = run.chi["robot_b"]
    assert len(solver.tick) > 90
    assert all(of_a[t] == r for t, r in zip(solver.tick, solver.references, strict=True))
    assert set(run.transition.reason.tolist()) == {""}, "no loss, no residual of another tick"
    for node in ("robot_a", "robot_b"):
        outcome = REPLAYERS[node](Question(run, Changes(), run.resolved))
        assert outcome.identical, outcome.line()


def test_messages_are_recorded_raw_and_decisions_carry_what_was_taken(mixed):
    _, folder = mixed
    topics = ("ee_trajectory", "base_path", "posture_trajectory")
    found = read(folder / "bag", *(f"/robot_a/{topic}" for topic in topics), "/robot_b/ee_twist")
    assert [len(messages) for messages in found.values()] == [1, 1, 1, 40]
    sent = read(folder / "bag", "/robot_a/references")["/robot_a/references"]
    kinds = {(t.robot, t.of, t.frame, t.kind) for m in sent for t in m.trajectories}
    assert kinds >= {
        ("robot_a", "ee", "tool", "waypoints"),
        ("robot_b", "ee", "tool", "twist"),
        ("robot_b", "ee", "panda_link4", "waypoints"),
        ("robot_a", "base", "tool", "spline"),
        ("robot_a", "posture", "tool", "spline"),
    }


def test_with_another_lead_in_the_replay_decides_on_the_same_trajectories_again(mixed):
    run, _ = mixed
    changes = Changes(("lead_in=1.5",))
    outcome = REPLAYERS["robot_a"](Question(run, changes, changes.applied(run.resolved)))
    assert 28 <= outcome.first <= 35, "the first trajectory, at tick 30"
    late = outcome.tick > 450
    np.testing.assert_allclose(outcome.replayed[late], outcome.recorded[late], atol=0.05)


def test_a_hold_in_the_middle_of_the_eight_brings_the_tool_to_rest(tmp_path):
    resolved = load_scenario(CONFIG / "scenarios" / "figure-of-eight.yaml", CONFIG)
    first = resolved.scenario.events[0]
    empty = {"robot_a": replace(first.ee_trajectory["robot_a"], times=(), positions=())}
    events = (first, EventConfig(3.0, ee_trajectory=empty))
    scenario = replace(resolved.scenario, events=events, duration=5.0)
    run = play(replace(resolved, scenario=scenario), tmp_path)
    assert np.abs(run.chi["robot_a"].chi[-50:]).max() < 2e-3
    assert np.abs(run.chi["robot_a"].chi[295:299]).max() > 0.05
    series = measure(run)
    assert series.ee_error[-1, 0] < 1.0
