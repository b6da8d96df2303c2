"""The parts of a transition: profiles, bridge, requests, announcements."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from lexstack.transition import (
    MAX_SCHEDULED,
    PROFILES,
    Announcement,
    SourceSchedule,
    alpha,
    quintic,
)
from lexstack.transition.bridge import bridged, goes_on, latch
from lexstack.transition.requests import RequestBook
from lexstack.types import LinearTask
from support.scenario import resolved

RNG = np.random.default_rng(3)


@pytest.mark.parametrize("name", [name for name in PROFILES if name != "time_optimal"])
def test_profiles_rise_from_0_to_1_and_stay(name):
    values = [alpha(name, t, 2.0) for t in np.linspace(-1.0, 3.0, 401)]
    assert values[0] == values[100] == 0.0
    assert values[300] == pytest.approx(1.0)
    assert values[-1] == pytest.approx(1.0)
    assert all(b >= a - 1e-15 for a, b in pairwise(values))
    assert alpha(name, 1.0, 2.0) == pytest.approx(0.5)


def test_the_fastest_profile_is_not_known_ahead():
    with pytest.raises(TypeError, match="time_optimal: its alpha is not known ahead"):
        alpha("time_optimal", 0.5, 1.0)


def test_the_quintic_starts_and_ends_without_acceleration():
    h = 1e-4
    for s in (0.0, 1.0 - 2 * h):
        a, b, c = (quintic(s + k * h) for k in range(3))
        assert abs(c - 2 * b + a) / h**2 < 0.05  # 10 pi^2 / ... of the cosine: 4.9
        assert abs(b - a) / h < 1e-5


def level():
    rows = RNG.normal(size=(4, 6))
    low = RNG.normal(size=4)
    return (
        LinearTask.equality("a", rows[:3], low[:3]),
        LinearTask("b", rows[3:], low[3:] - 0.1, low[3:] + 0.1),
    )


def test_at_alpha_0_the_last_command_is_the_optimum_and_at_1_the_source():
    command, source, tasks = RNG.normal(size=6), RNG.normal(size=6), level()
    bridge = latch(command, source, tasks, level_goes_on=False)
    first, follow = bridged(bridge, tasks, source, 0.0)
    np.testing.assert_allclose(first[0].residual(command), 0.0, atol=1e-12)
    np.testing.assert_array_equal(first[1].lower, tasks[1].lower, "an inequality holds at once")
    np.testing.assert_array_equal(first[1].upper, tasks[1].upper)
    np.testing.assert_allclose(follow, command, atol=1e-12)
    first, follow = bridged(bridge, tasks, source, 1.0)
    np.testing.assert_array_equal(follow, source)
    for task, plain in zip(first, tasks, strict=True):
        np.testing.assert_array_equal(task.lower, plain.lower)
        np.testing.assert_array_equal(task.upper, plain.upper)


def test_a_level_that_goes_on_is_not_touched():
    command, source, tasks = RNG.normal(size=6), RNG.normal(size=6), level()
    first, _ = bridged(latch(command, source, tasks, level_goes_on=True), tasks, source, 0.3)
    assert first is tasks


def test_a_level_goes_on_while_its_targets_move_by_less_than_the_joints_reach():
    tasks, reach = level(), np.full(6, 0.01)
    assert goes_on(tasks, tasks, reach)
    assert not goes_on(tasks, tasks[:1], reach)
    assert not goes_on(tasks, (tasks[0], dataclasses.replace(tasks[1], name="x")), reach)
    turned = dataclasses.replace(tasks[1], matrix=tasks[1].matrix + 1e-9)
    assert not goes_on(tasks, (tasks[0], turned), reach)
    for end in ("lower", "upper"):
        for step, follows in ((1e-4, True), (1.0, False)):
            moved = dataclasses.replace(tasks[1], **{end: getattr(tasks[1], end) + step})
            assert goes_on(tasks, (tasks[0], moved), reach) is follows
    endless = dataclasses.replace(tasks[1], upper=np.array([np.inf]))
    assert goes_on((tasks[0], endless), (tasks[0], endless), reach)


# ---- requests


def book():
    stacks = {"track": (0, 1), "posture": (0, 1), "posture_a": (0,), "posture_b": (1,)}
    return RequestBook(stacks, ("bridge",), resolved().scenario.transition)


def test_a_request_takes_the_configured_values():
    answer = book().ask("posture", 0.0, "", 0, now=41)
    assert answer.accepted
    request = answer.request
    assert (request.id, request.at_tick, request.method) == (1, 42, "bridge")
    assert request.duration == resolved().scenario.transition.duration


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            ("dance", 0.0, "", 0),
            "unknown stack 'dance'; known: posture, posture_a, posture_b, track",
        ),
        (("track", -1.0, "", 0), "duration: must be in [0, 60] s"),
        (("track", float("nan"), "", 0), "duration"),
        (("track", float("inf"), "", 0), "duration"),
        (("track", 61.0, "", 0), "duration"),
        (("track", 0.0, "jump", 0), "unknown method 'jump'; known: bridge"),
        (("track", 0.0, "", 10), "at_tick: 10 is over; the present tick is 10"),
        (
            ("track", 0.0, "", 6011),
            "at_tick: 6011 is 6001 ticks ahead of the present tick 10, more than 6000",
        ),
    ],
)
def test_a_wrong_request_is_refused_with_its_reason(values, message):
    requests = book()
    answer = requests.ask(*values, now=10)
    assert not answer.accepted
    assert message in answer.message
    assert answer.request is None
    assert requests.scheduled == ()


def test_requests_for_one_robot_do_not_fill_the_queue_of_another():
    requests = book()
    for tick in range(100, 100 + MAX_SCHEDULED):
        assert requests.ask("posture_a", 0.0, "", tick, now=0).accepted
    assert "requests are scheduled already" in requests.ask("posture_a", 0.0, "", 99, now=0).message
    assert requests.ask("posture_b", 0.0, "", 99, now=0).accepted
    assert requests.ask("posture_a", 0.0, "", 0, now=0).accepted, "it waits for nothing"


def test_requests_are_due_in_the_order_of_their_ticks():
    requests = book()
    for tick in (30, 10, 20):
        requests.ask("track", 0.0, "", tick, now=0)
    assert [r.at_tick for r in requests.scheduled] == [10, 20, 30]
    assert requests.due(9) == ()
    assert [r.id for r in requests.peek(20)] == [3]
    assert [r.id for r in requests.due(20)] == [3], "the newest; the earlier are overtaken"
    assert [r.at_tick for r in requests.scheduled] == [30]


def test_a_later_request_for_the_same_tick_replaces():
    requests = book()
    requests.ask("track", 0.0, "", 10, now=0)
    requests.ask("posture", 0.0, "", 10, now=0)
    assert [(r.id, r.stack) for r in requests.scheduled] == [(2, "posture")]


def test_requests_for_different_robots_stand_beside_each_other():
    requests = book()
    for stack in ("posture_a", "posture_b", "posture_a"):
        requests.ask(stack, 0.0, "", 10, now=0)
    assert [(r.id, r.robots) for r in requests.scheduled] == [(2, (1,)), (3, (0,))]
    requests.ask("posture_b", 0.0, "", 8, now=0)
    assert [r.id for r in requests.due(10)] == [2, 3], "4 is overtaken for the same robot"
    requests.ask("track", 0.0, "", 20, now=10)
    requests.ask("posture_b", 0.0, "", 20, now=10)
    assert [r.stack for r in requests.peek(20)] == ["track", "posture_b"]
    requests.ask("posture", 0.0, "", 20, now=10)
    assert [r.stack for r in requests.due(20)] == ["posture"], "it moves all of their robots"


def test_a_flood_is_refused_but_the_last_word_counts():
    requests = book()
    for tick in range(1, MAX_SCHEDULED + 1):
        assert requests.ask("track", 0.0, "", tick, now=0).accepted
    assert not requests.ask("track", 0.0, "", MAX_SCHEDULED + 1, now=0).accepted
    assert requests.ask("posture", 0.0, "", 5, now=0).accepted
    for _ in range(1000):
        assert requests.ask("posture", 0.0, "", 0, now=0).accepted
    assert len(requests.scheduled) == MAX_SCHEDULED


# ---- the source's side


def test_the_source_solves_the_newest_stack_whose_tick_has_come():
    schedule = SourceSchedule()
    one = Announcement(1, "track", 10, active=True)
    two = Announcement(2, "posture", 20, active=True)
    schedule.hear(two)
    schedule.hear(one)
    assert schedule.current(9) == ()
    assert schedule.current(10) == (one,)
    assert schedule.current(20) == (two,)
    schedule.hear(dataclasses.replace(two, active=False, start_tick=21))
    assert schedule.current(21) == (), "what it replaced does not come back"


def test_the_source_solves_stacks_of_different_robots_at_the_same_time():
    schedule = SourceSchedule()
    both = Announcement(1, "track", 10, active=True)
    one = Announcement(2, "posture_a", 20, active=True, robots=(0,))
    other = Announcement(3, "posture_b", 30, active=True, robots=(1,))
    for announcement in (other, one, both):
        schedule.hear(announcement)
    assert schedule.current(30) == (both, one, other), "the rest of the first one still needs it"
    again = Announcement(4, "track_a", 31, active=True, robots=(0,))
    schedule.hear(again)
    assert schedule.current(31) == (both, other, again)
    everyone = Announcement(5, "posture", 40, active=True, robots=(0, 1))
    schedule.hear(everyone)
    assert schedule.current(40) == (both, everyone), "that one said nothing of its robots"


def test_an_announcement_that_is_withdrawn_is_forgotten():
    schedule = SourceSchedule()
    schedule.hear(Announcement(1, "track", 10, active=True))
    schedule.hear(Announcement(1, "track", 0, active=False))
    assert schedule.current(10) == ()


def test_an_end_may_be_told_ahead_and_taken_back():
    schedule = SourceSchedule()
    one = Announcement(1, "track", 10, active=True)
    schedule.hear(one)
    schedule.hear(Announcement(1, "track", 20, active=False))
    assert schedule.current(19) == (one,)
    schedule.hear(one)
    assert schedule.current(20) == (one,)
    schedule.hear(Announcement(1, "track", 21, active=False))
    assert schedule.current(21) == ()
    assert schedule.current(22) == ()
