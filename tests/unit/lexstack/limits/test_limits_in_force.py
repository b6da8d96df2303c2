"""The limits in force, tick by tick and by hand."""

import numpy as np
import pytest

from lexstack.limits import JointLimits, LimitOptions, LimitsInForce, viable_bounds
from lexstack.types import RobotState

DT = 0.01


def limits(lower=-2.0, upper=2.0, velocity=1.0, acceleration=10.0, jerk=200.0):
    return JointLimits(*(np.atleast_1d(x) for x in (lower, upper, velocity, acceleration, jerk)))


def state(tick, q=0.0, chi=0.0):
    q, chi = np.atleast_1d(q), np.atleast_1d(chi)
    return RobotState(tick, DT * tick, q, chi, q, chi)


def same(box, other):
    return np.array_equal(box.lower, other.lower) and np.array_equal(box.upper, other.upper)


def test_limits_that_stay_give_the_viable_box():
    own = limits()
    force = LimitsInForce(own, LimitOptions(DT))
    at, box = force.at(state(5, 1.8, 0.4), own, None, jerk=False)
    assert at is own
    assert same(box, viable_bounds(np.array([1.8]), own, DT, np.array([0.4])))
    sent = np.array([0.5])
    box = force.at(state(6, 1.8, 0.4), own, sent, jerk=False)[1]
    assert same(box, viable_bounds(np.array([1.8]), own, DT, np.array([0.4]), sent))


@pytest.mark.parametrize("always", [True, False])
def test_with_jerk_limits_the_last_acceleration_comes_from_two_states(always):
    own = limits()
    force = LimitsInForce(own, LimitOptions(DT, jerk=always))
    box = force.at(state(5, 0.0, 0.40), own, None, jerk=not always)[1]
    assert (box.lower.item(), box.upper.item()) == pytest.approx((0.38, 0.42))
    box = force.at(state(6, 0.0, 0.41), own, None, jerk=not always)[1]
    assert (box.lower.item(), box.upper.item()) == pytest.approx((0.40, 0.44))
    # Ticks are missing: 0.06 in 3 of them.
    box = force.at(state(9, 0.0, 0.47), own, None, jerk=not always)[1]
    assert (box.lower.item(), box.upper.item()) == pytest.approx((0.47, 0.51))
    # The plant began anew.
    box = force.at(state(0, 0.0, 0.0), own, None, jerk=not always)[1]
    assert (box.lower.item(), box.upper.item()) == pytest.approx((-0.02, 0.02))


def test_other_limits_are_reached_by_a_blend_and_left_by_another_one():
    own, other = limits(), limits(upper=0.0)
    force = LimitsInForce(own, LimitOptions(DT))
    q, chi, ends = 0.45, 0.0, {}
    for tick in range(200):
        wanted = other if 10 <= tick < 30 or tick >= 60 else own
        at, box = force.at(state(tick, q, chi), wanted, None, jerk=False)
        assert box.empty == 0
        if at is wanted:
            ends.setdefault((tick - 10) // 10, tick)
        chi = box.upper.item() if wanted is own else box.lower.item()
        q += DT * chi
        if tick == 12:
            # drawn inside by v^2 / 2 a + v dt; see test_limits
            assert at.position_upper.item() == pytest.approx(-0.06)
        if 30 <= tick < 60:
            assert at is own
    assert q <= 1e-12
    assert at is other


def test_position_limits_may_take_a_given_time():
    own, other = limits(), limits(upper=0.0)
    force = LimitsInForce(own, LimitOptions(DT, duration=0.5))
    uppers = [
        force.at(state(tick, 0.45), other, None, jerk=False)[0].position_upper.item()
        for tick in range(51)
    ]
    assert uppers[24] == pytest.approx(0.225)
    assert uppers[49:] == [0.0, 0.0]


def run(own, force, q, chi, jerk, ticks=100):
    """Return positions and velocities of a joint that goes up as fast as it may."""
    told = []
    for tick in range(ticks):
        box = force.at(state(tick, q, chi), own, None, jerk=jerk(tick))[1]
        chi = box.upper.item()
        q += DT * chi
        told.append((q, chi))
    return np.array(told).T


def test_jerk_limits_that_come_into_force_wait_for_a_joint_that_is_too_fast_for_them():
    """It brakes with all there is in front of its limit: with less jerk it would pass it."""
    own = limits(upper=1.0, jerk=100.0)
    inside = LimitsInForce(own, LimitOptions(DT))
    q, chi = run(own, inside, 0.8, 0.0, lambda tick: tick >= 10)
    assert q.max() <= 1.0 + 1e-12
    outside = LimitsInForce(own, LimitOptions(DT, jerk=True))
    outside.at(state(-1, q[8], chi[8]), own, None, jerk=True)
    assert run(own, outside, q[9], chi[9], lambda _: True)[0].max() > 1.0 + 1e-3


def test_jerk_limits_that_come_into_force_wait_for_a_joint_near_its_velocity_limit():
    own = limits(upper=9.0, jerk=100.0)
    _, chi = run(own, LimitsInForce(own, LimitOptions(DT)), 0.0, 0.0, lambda tick: tick >= 9)
    assert chi[8] == pytest.approx(0.9)
    assert chi.max() <= 1.0 + 1e-12
    change = np.diff(chi, 2)
    assert np.abs(change[np.abs(chi[2:] - chi[1:-1]) < 1e-12][1:]).max() <= 100.0 * DT**2 + 1e-12


def test_once_in_force_nothing_is_made_anew():
    own = limits()
    force = LimitsInForce(own, LimitOptions(DT, jerk=True))
    kept = set()
    for tick in range(5):
        force.at(state(tick), own, None, jerk=True)
        kept.add(id(force._kept))
    assert kept == {id(own)}
