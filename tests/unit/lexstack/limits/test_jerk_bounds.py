"""Bounds with jerk limits against numbers worked out by hand."""

import math

import numpy as np
import pytest

from lexstack.limits import JerkLaw, JointLimits, viable_bounds
from lexstack.limits.stopping import largest_stoppable_change
from support.scenario import team

INF = math.inf
DT = 0.1


def limits(lower=-1.0, upper=1.0, velocity=2.0, acceleration=1.0, jerk=2.0):
    return JointLimits(*(np.atleast_1d(x) for x in (lower, upper, velocity, acceleration, jerk)))


def box(q, v, a, **kwargs):
    bounds = viable_bounds(
        np.array([q]), limits(**kwargs), DT, np.array([v]), acceleration=np.array([a])
    )
    return bounds.lower.item(), bounds.upper.item()


# a = 1, j = 2, dt = 0.1: the velocity changes by at most 0.1, and that by at most 0.02
@pytest.mark.parametrize(
    ("q", "v", "a", "expected"),
    [
        pytest.param(0.0, 0.0, 0.0, (-0.02, 0.02), id="from rest: jerk decides"),
        pytest.param(0.0, 0.3, 0.9, (0.37, 0.4), id="acceleration and jerk decide"),
        pytest.param(0.0, 0.0, -0.5, (-0.07, -0.03), id="braking goes on for a while"),
        pytest.param(0.0, 0.0, 3.0, (0.1, 0.1), id="above the acceleration limit: that goes first"),
        pytest.param(1.0, 0.0, 0.0, (-0.02, 0.0), id="at the limit, at rest"),
        pytest.param(1.0, 0.0, -0.4, (-0.06, -0.02), id="at the limit, going back"),
        pytest.param(1.2, 0.0, 0.0, (-0.02, -0.02), id="outside, at rest: starts to return"),
        pytest.param(0.99, 0.9, 0.0, (0.88, 0.88), id="too fast to stop in time: all it has"),
        pytest.param(-0.99, -0.9, 0.0, (-0.88, -0.88), id="the same at the lower limit"),
    ],
)
def test_a_joint_by_hand(q, v, a, expected):
    assert box(q, v, a) == pytest.approx(expected, abs=1e-12)


def test_the_velocity_limit_is_met_without_a_jump():
    # u(0.01; 0.02) = -0.02 + sqrt(0.02^2 + 2 * 0.02 * 0.01)
    free = {"lower": -INF, "upper": INF}
    most = 1.99 - 0.02 + math.sqrt(0.0004 + 0.0004)
    assert box(0.0, 1.99, 0.1, **free) == pytest.approx((1.98, most), abs=1e-12)
    assert box(0.0, 2.0, 0.2, **free) == pytest.approx((2.0, 2.0), abs=1e-12)


@pytest.mark.parametrize(
    ("v", "change", "room"),
    [
        # In units of S, A = 2: room = v' + D
        pytest.param(1.0, 0.5, 1.5 + 1.5**1.5, id="c = 0, no hold"),
        pytest.param(7.5, 0.5, 8.0 + 16.0 + 8.0, id="c = 0, z = 8, held at P = A"),
        pytest.param(2.5, -0.5, 2.0 - 2.5 + 1.0 / 6 + 2.5**1.5, id="the deceleration grows"),
        pytest.param(0.5, 1.5, 2.0 + 2.5 - 1.0 / 6 + 2.5**1.5 + 0.5, id="it gets faster first"),
        pytest.param(4.0, -2.0, 2.0 + 2.0 * 2.0 / 3.0, id="it lands: c = -sqrt(2 v)"),
        pytest.param(-2.5, 1.5, -1.0, id="it goes back and stays there"),
        pytest.param(-2.0, 2.0, 0.0 + 1.6875 - 0.5625 + 1.125**1.5 + 1.125, id="stands, then goes"),
    ],
)
def test_the_look_ahead_by_hand(v, change, room):
    if room >= 0.0:
        found = largest_stoppable_change(room, v, 2.0, change - 0.9, change + 0.9)
        assert found == pytest.approx(change, abs=1e-9)
    assert largest_stoppable_change(max(room, 0.0) + 1e-6, v, 2.0, change - 0.9, change) == change


def test_with_no_room_it_brakes_with_all_there_is():
    assert largest_stoppable_change(0.0, 3.0, 2.0, -1.0, 1.0) == -1.0
    assert largest_stoppable_change(1.0, INF, 2.0, -1.0, 1.0) == -1.0


@pytest.mark.parametrize("rate", [100.0, 500.0, 1000.0])
def test_our_robots_use_all_of_their_acceleration(rate):
    own = team().limits
    law = JerkLaw(
        (own.position_lower, own.position_upper), own.velocity, own.acceleration, own.jerk, 1 / rate
    )
    np.testing.assert_array_equal(law.usable, own.acceleration)


def test_in_a_narrow_range_it_uses_less():
    narrow = limits(lower=0.0, upper=0.001)
    law = JerkLaw(
        (narrow.position_lower, narrow.position_upper),
        narrow.velocity,
        narrow.acceleration,
        narrow.jerk,
        DT,
    )
    # S cbrt(1/8 + W / (dt S)) with S = 0.02, W / dt = 0.01
    assert law.usable.item() == pytest.approx(0.02 * 0.625 ** (1 / 3) / DT)


def test_a_number_that_is_none_makes_the_interval_empty():
    for q, v, a in ((np.nan, 0.0, 0.0), (0.0, np.nan, 0.0), (0.0, 0.0, np.nan)):
        lower, upper = box(q, v, a)
        assert not lower <= upper


def test_bounds_are_read_only():
    bounds = viable_bounds(np.zeros(1), limits(), DT, np.zeros(1), acceleration=np.zeros(1))
    for side in (bounds.lower, bounds.upper):
        with pytest.raises(ValueError, match="read-only"):
            side[0] = 0.0


def test_what_was_sent_may_not_have_arrived():
    args = (np.zeros(3), limits(*(np.full(3, x) for x in (-9, 9, 2, 1, 2))), DT, np.full(3, 0.5))
    sent, a = np.array([0.5, 0.61, 0.75]), np.zeros(3)
    bounds = viable_bounds(*args, sent, a)
    # S = 0.02 about 0.5; within 0.1 of what was sent; too far apart: the plant's counts
    np.testing.assert_allclose(bounds.lower, [0.48, 0.51, 0.48], atol=1e-12)
    np.testing.assert_allclose(bounds.upper, [0.52, 0.52, 0.52], atol=1e-12)
