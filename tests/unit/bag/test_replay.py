"""Replay: what is changed, what users asked for, and where chi differs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lexstack.errors import ConfigurationError
from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.outcome import Joint, Outcome
from lexstack_bag.replay.requests import Ask, Cancel, requests_of
from lexstack_bag.run.reader import read_run
from lexstack_bag.run.run import StackRequested

PHASES = {"idle": 0, "requested": 1, "preparing": 2, "blending": 3, "adopting": 4, "aborted": 5}


def outcome(recorded, replayed, first_tick=10):
    recorded, replayed = np.array(recorded, float), np.array(replayed, float)
    tick = first_tick + np.arange(len(recorded))
    joints = (Joint("r/base_x", "m/s"), Joint("r/base_yaw", "rad/s"))
    return Outcome("robot_a", joints, tick, 0.01 * tick, recorded, replayed)


# ---- where chi differs


def test_identical_means_every_bit():
    same = outcome([[1.0, 2.0], [np.nan, np.nan]], [[1.0, 2.0], [np.nan, np.nan]])
    assert same.identical
    assert same.line() == "robot_a: identical over all 2 ticks"
    bit = np.nextafter(2.0, 3.0)
    other = outcome([[1.0, 2.0], [1.0, 2.0], [1.0, 2.0]], [[1.0, 2.0], [1.0, bit], [1.0, 2.0]])
    assert (other.first, other.identical) == (11, False)
    assert other.different.tolist() == [False, True, False]
    assert "differs first at tick 11 (0.11 s), in 1 of 3 ticks" in other.line()
    assert outcome([[0.0, 0.0]], [[-0.0, 0.0]]).first == 10, "the sign of zero is a bit"


def test_a_missing_chi_differs():
    assert outcome([[1.0, 2.0]], [[np.nan, np.nan]]).first == 10


def test_the_largest_difference_by_unit():
    found = outcome([[0.0, 0.0], [0.0, 0.0]], [[0.5, 0.0], [0.1, -2.0]])
    assert list(found.largest()) == [
        (0.5, "m/s", "r/base_x", pytest.approx(0.10)),
        (2.0, "rad/s", "r/base_yaw", pytest.approx(0.11)),
    ]
    assert found.plain()["largest"][1]["joint"] == "r/base_yaw"


def test_nothing_recorded():
    empty = outcome(np.zeros((0, 2)), np.zeros((0, 2)))
    assert empty.line() == "robot_a: no chi recorded"
    assert list(empty.largest()) == []


# ---- changes


def test_any_key_can_be_changed(resolved):
    changes = Changes(
        (
            "transition.duration=0.5",
            "scenario.rate=50",
            "stacks.reach_base.levels.1.tasks.0.parameters.gain=2.5",
            "stacks.track.levels.0.tasks.0.weight=3",
            "robots.panda_summit.name=other",
        ),
        method="t37",
        solver="proxqp",
    )
    changed = changes.applied(resolved)
    assert changed.scenario.transition.duration == 0.5
    assert changed.scenario.transition.method == "t37"
    assert changed.scenario.rate == 50.0
    assert changed.scenario.solver == "proxqp"
    assert changed.stacks["reach_base"].levels[1].tasks[0].parameters == {"gain": 2.5}
    assert changed.stacks["track"].levels[0].tasks[0].weight == 3.0
    assert changed.robots["panda_summit"].name == "other"
    assert resolved.scenario.rate == 100.0
    assert str(changes).startswith("transition.duration=0.5, scenario.rate=50")
    assert changes
    assert not Changes()
    assert Changes().applied(resolved) == resolved


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (Changes(("rate",)), "--set: expected KEY=VALUE, got 'rate'"),
        (Changes(("speed=3",)), "--set: scenario: unknown key 'speed'; known: name, description"),
        (Changes(("rate=fast",)), "rate: expected float, got 'fast'"),
        (Changes(("rate=[",)), "--set: rate: not valid YAML"),
        (Changes(("rate.x=1",)), "--set: scenario.rate: is a value, it has no 'x'"),
        (
            Changes(("stacks.track.levels.9.tasks=1",)),
            "stacks.track.levels: no entry '9'; it has 2",
        ),
        (Changes((f"stacks.track.levels.{'9' * 5000}.tasks=1",)), "stacks.track.levels: no entry"),
        (Changes(("transition.duration=-1",)), "duration: must be finite and > 0, got -1.0"),
        (Changes(method="jump"), "transition.method: unknown method 'jump'; known: bridge"),
        (Changes(stack="dance"), "--stack: unknown 'dance'; known: reach_base, track"),
        (Changes(stack="a=track"), "--stack: unknown 'a'; known: reach_base, track"),
    ],
)
def test_a_change_that_makes_no_sense_is_refused(resolved, changes, message):
    with pytest.raises(ConfigurationError) as error:
        changes.applied(resolved)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


# ---- what users asked for


@pytest.fixture(scope="module")
def run(synthetic):
    return read_run(synthetic.folder)


def with_requests(run, *requested, **status):
    fields = {name: np.array(getattr(run.transition, name)) for name in ("phase", "id", "reason")}
    for name, values in status.items():
        for row, value in values.items():
            fields[name][row] = value
    return replace(run, requested=requested, transition=replace(run.transition, **fields))


def told(after, id_, stack="reach_base", start=100, active=True):
    return StackRequested(after, id_, stack, start, active)


def test_a_request_comes_back_with_its_duration_and_method(run):
    # The blend of the run lasts for the configured 1 s with the configured method.
    requested = with_requests(run, told(40, 1), told(200, 1, start=202, active=False))
    (ask,) = requests_of(requested, Changes(), run.resolved)
    assert ask == Ask(40, 1, "reach_base", 100, 0.0, ""), "as configured"
    slow = with_requests(run, told(40, 1))
    slow = replace(slow, transition=replace(slow.transition, duration=np.full(400, 2.5)))
    (ask,) = requests_of(slow, Changes(), run.resolved)
    assert ask.duration == 2.5


def test_a_request_told_again_is_one_request(run):
    again = with_requests(run, told(40, 1), told(120, 1), told(200, 1, active=False))
    assert len(requests_of(again, Changes(), run.resolved)) == 1


def test_the_stack_of_switches_can_be_replaced(run):
    requested = with_requests(run, told(40, 1), told(50, 2, "track", 300))
    stacks = lambda change: [  # noqa: E731
        ask.stack for ask in requests_of(requested, Changes(stack=change), run.resolved)
    ]
    assert stacks("track") == ["track", "track"]
    assert stacks("track=reach_base") == ["reach_base", "reach_base"]
    assert stacks("reach_base=track") == ["track", "track"]


def test_a_cancellation_drops_what_is_to_come_and_goes_back_by_itself(run):
    cancelled = with_requests(
        run,
        told(40, 1),
        told(40, 2, "track", 350),
        told(150, 2, "track", 0, active=False),
        told(150, 3, "track", 151),
        told(180, 4, "reach_base", 190),
        phase={151: PHASES["aborted"]},
        id=dict.fromkeys(range(152, 180), 3),
        reason={151: "transition 1 was cancelled"}
        | dict.fromkeys(range(152, 180), "transition 1 was cancelled; going back"),
    )
    requests = requests_of(cancelled, Changes(), run.resolved)
    assert [(type(r), r.after) for r in requests] == [
        (Ask, 40),
        (Ask, 40),
        (Cancel, 150),
        (Ask, 180),
    ]
    assert [r.id for r in requests if isinstance(r, Ask)] == [1, 2, 4]
