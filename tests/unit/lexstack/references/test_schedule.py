"""Which references hold from which tick on, and how a set-point is led in."""

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.errors import InputError
from lexstack.references import (
    BASES,
    POSES,
    References,
    ReferenceSchedule,
    ReferenceTimeline,
    SetPoint,
    Target,
    decode,
    encode,
)
from lexstack.robots import Pose, log3

DT = 0.01
LEAD = 0.5
ORIGIN = Pose(np.zeros(3), np.eye(3))


def pose(x, turn=(0.0, 0.0, 0.0)):
    return Pose(np.array([x, 0.0, 0.5]), pin.exp3(np.array(turn)))


def schedule(lead_in=LEAD, horizon=60.0):
    return ReferenceSchedule(
        References((ORIGIN,), (np.zeros(3),)), lead_in=lead_in, horizon=horizon
    )


def test_a_target_stamped_with_the_wall_clock_is_refused_with_the_reason():
    made = schedule()
    made.decide(12.0)
    with pytest.raises(InputError, match=r"ee_target: stamp 1\.8e\+09|ee_target: stamp 18.* ahead"):
        made.add(Target(1.8e9, 0, ee=pose(1.0)))
    made.add(Target(72.0, 0, ee=pose(1.0)))
    with pytest.raises(InputError, match="more than 60 s; stamp 0 means now"):
        made.add(Target(72.1, 0, ee=pose(1.0)))


def test_nobody_can_fill_the_queue_of_another_robot_kind_or_of_what_is_sooner():
    made = ReferenceSchedule(References((ORIGIN, ORIGIN), (np.zeros(3), np.zeros(3))), horizon=60.0)
    made.decide(0.0)
    for k in range(10_000):
        made.add(Target(50.0 + 1e-4 * k, 0, ee=pose(1.0)))
    with pytest.raises(InputError, match=r"10000 are to come already, the one for 51\.5"):
        made.add(Target(51.5, 0, ee=pose(1.0)))
    made.add(Target(0.0, 1, ee=pose(2.0)))
    made.add(Target(0.0, 0, base=np.ones(3)))
    with pytest.raises(InputError, match=r"the one for 51\.000 s is left out"):
        made.add(Target(0.0, 0, ee=pose(3.0)))
    made.decide(DT)
    newest = made.timeline.newest
    assert newest.ee[0].goal.position[0] == 3.0
    assert newest.ee[1].goal.position[0] == 2.0
    assert newest.base[0].goal[0] == 1.0


def test_a_tick_is_decided_once_and_what_comes_later_waits():
    made = schedule(lead_in=0.0)
    made.decide(1.0)
    made.add(Target(0.0, 0, ee=pose(1.0)))
    assert made.at(1.0).ee[0] is ORIGIN
    assert made.at(1.0 + DT).ee[0].position[0] == 1.0


def test_a_target_that_comes_twice_is_one_decision():
    made = schedule()
    made.decide(0.0)
    for stamp in (0.1, 0.2, 0.3):
        made.add(Target(0.0, 0, ee=pose(1.0), base=None))
        made.decide(stamp)
    assert made.timeline.newest.revision == 2
    assert [setting.at for setting in made.take_news()] == [0.0, 0.1]
    assert made.take_news() == []


def test_the_first_references_are_measured_where_the_scenario_gives_none():
    made = schedule()
    made._given = (frozenset(), frozenset({0}))
    measured = References((pose(4.0),), (np.full(3, 4.0),))
    made.begin(measured)
    first = made.at(0.0)
    assert first.ee[0] is measured.ee[0]
    assert first.base[0][0] == 0.0
    made.begin(References((pose(5.0),), (np.zeros(3),)))
    assert made.at(DT) is first, "only the first state counts"


def test_a_controller_that_starts_again_goes_on_with_the_last_decision():
    old, new = schedule(), schedule()
    old.add(Target(0.0, 0, ee=pose(1.0)))
    for stamp in (0.0, 0.1):
        old.decide(stamp)
    new.resume(old.timeline.newest, 0.2)
    for stamp in (0.2, 0.3, 1.0):
        np.testing.assert_array_equal(old.at(stamp).ee[0].position, new.at(stamp).ee[0].position)
    assert new.at(1.0).ee[0].position[0] == 1.0


def test_references_stay_the_same_object_while_none_moves():
    made = schedule()
    made.decide(0.0)
    assert made.at(0.1) is made.at(0.2)
    made.add(Target(0.0, 0, ee=pose(1.0)))
    moving = [made.at(0.3 + k * DT) for k in range(3)]
    assert len({id(entry) for entry in moving}) == 3
    assert {entry.revision for entry in moving} == {2}
    assert moving[0].base[0] is moving[1].base[0]
    assert made.at(0.9) is made.at(1.0)


@st.composite
def trains(draw):
    """Return targets as (tick, position, rotation vector)."""
    count = draw(st.integers(1, 6))
    number = st.floats(-1.0, 1.0)
    turn = st.floats(-3.0, 3.0)
    return [
        (
            draw(st.integers(0, 100)),
            [draw(number) for _ in range(3)],
            [draw(turn) for _ in range(3)],
        )
        for _ in range(count)
    ]


@settings(max_examples=60, deadline=None)
@given(trains())
def test_the_way_to_a_target_has_no_jump_in_position_velocity_or_acceleration(train):
    """Third differences stay below what the quintic's jerk allows, whenever targets come."""
    point, largest = SetPoint(ORIGIN), 0.0
    coming = sorted(train, key=lambda entry: entry[0])
    fine = 0.002  # s
    values, turns = [], []
    for k in range(1000):
        stamp = k * fine
        while coming and coming[0][0] * DT <= stamp:
            _, position, turn = coming.pop(0)
            goal = Pose(np.array(position), pin.exp3(np.array(turn)))
            largest = max(largest, float(np.linalg.norm(POSES.gap(goal, point.at(stamp, POSES)))))
            point = point.led_to(goal, stamp, LEAD, POSES)
        now = point.at(stamp, POSES)
        values.append(now.position)
        turns.append(now.rotation)
    # A train of targets can raise rate and curvature at each latch, by bounded factors.
    bound = 60.0 / LEAD**3 * max(largest, 1e-9) * 60.0
    jerk = np.diff(np.array(values), n=3, axis=0) / fine**3
    assert np.abs(jerk).max() <= bound + 1e-3
    speed = np.array([log3(a.T @ b) for a, b in pairwise(turns)]) / fine
    assert np.abs(np.diff(speed, axis=0)).max() / fine <= 100.0 * max(largest, 1e-9) / LEAD**2
    np.testing.assert_array_equal(point.at(2.0 + LEAD, POSES).rotation, point.goal.rotation)


def test_a_new_goal_on_the_way_goes_on_with_its_velocity_and_acceleration():
    point = SetPoint(np.zeros(3)).led_to(np.array([1.0, -0.5, 3.0]), 0.0, LEAD, BASES)
    h, now = 1e-4, 0.2
    other = point.led_to(np.array([-1.0, 2.0, -3.0]), now, LEAD, BASES)

    def derivatives(one, side):
        a, b, c = (one.at(now + side * k * h, BASES) for k in range(3))
        return (b - a) / (side * h), (c - 2.0 * b + a) / h**2

    before, after = derivatives(point, -1.0), derivatives(other, 1.0)
    np.testing.assert_allclose(after[0], before[0], atol=0.02 * np.abs(before[0]).max())
    np.testing.assert_allclose(after[1], before[1], atol=0.03 * 60.0 / LEAD**2)


def test_a_base_turns_the_short_way():
    point = SetPoint(np.array([0.0, 0.0, 3.0])).led_to(np.array([0.0, 0.0, -3.0]), 0.0, LEAD, BASES)
    yaw = [point.at(0.01 * k, BASES)[2] for k in range(60)]
    assert abs(yaw[0] - (3.0 - 2.0 * np.pi)) < 1e-12
    assert max(yaw) - min(yaw) < 0.3
    assert yaw[-1] == -3.0


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.6, -0.8, 0.0), (-0.3, 0.3, 0.9)])
def test_a_second_target_near_half_a_turn_is_no_jump(axis):
    """The rotation vector changes its sign at pi: its difference is no speed."""
    axis = np.array(axis) / np.linalg.norm(axis)
    point = SetPoint(ORIGIN).led_to(Pose(np.zeros(3), pin.exp3(1.0 * axis)), 0.0, LEAD, POSES)
    stamp = 0.25
    far = Pose(np.zeros(3), point.at(stamp, POSES).rotation @ pin.exp3(np.pi * axis))
    other = point.led_to(far, stamp, LEAD, POSES)
    assert np.abs(other.fading.rate[3:]).max() < 10.0


def test_whoever_hears_the_decisions_has_the_same_references_bit_for_bit():
    rng = np.random.default_rng(5)
    made, heard = schedule(), ReferenceTimeline()
    for tick in range(300):
        stamp = tick * DT
        if tick % 17 == 3:
            made.add(Target(0.0, 0, ee=pose(rng.normal(), rng.normal(size=3))))
        if tick % 23 == 5:
            made.add(Target(stamp + 0.05, 0, base=rng.normal(size=3)))
        made.decide(stamp)
        for setting in made.take_news():
            vectors = {name: vector.tolist() for name, vector in encode(setting).items()}
            assert heard.hear(decode(setting.at, setting.revision, vectors, 1, "here"))
        mine, other = made.at(stamp), heard.at(stamp)
        assert mine.revision == other.revision
        np.testing.assert_array_equal(mine.ee[0].position, other.ee[0].position)
        np.testing.assert_array_equal(mine.ee[0].rotation, other.ee[0].rotation)
        np.testing.assert_array_equal(mine.base[0], other.base[0])


def test_decisions_of_the_past_and_after_a_reset():
    made, heard = schedule(), ReferenceTimeline()
    for k in range(3):
        made.add(Target(0.0, 0, ee=pose(float(k + 1))))
        made.decide(float(k))
    first, second, third = made.take_news()
    assert heard.hear(first)
    assert heard.hear(third)
    assert not heard.hear(third)
    assert not heard.covers(-1.0)
    again = schedule()
    again.count_on(made)
    again.decide(0.0)
    (anew,) = again.take_news()
    assert anew.revision == third.revision + 1
    assert heard.hear(anew), "the plant was reset: time begins anew"
    assert heard.at(5.0).ee[0] is ORIGIN
    assert second.revision == 2


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("ee", [0.0] * 11, "ee: expected 12 values, got 11"),
        ("ee", [0.0] * 12, "no rotation matrix"),
        ("base", [0.0, float("nan"), 0.0], "base: every value must be finite"),
        ("base", [1e9, 0.0, 0.0], "base: out of range"),
        ("base_lead", [0.0], "base_lead: expected 11 values, got 1"),
    ],
)
def test_a_decision_that_does_not_fit_is_refused(name, value, reason):
    made = schedule()
    made.decide(0.0)
    vectors = encode(made.timeline.newest) | {name: value}
    with pytest.raises(InputError, match=reason):
        decode(0.0, 1, vectors, 1, "/robot_a/references")
