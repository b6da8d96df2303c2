"""Bounds on chi against numbers worked out by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lexstack.errors import ModelError
from lexstack.limits import (
    Bounds,
    JointLimits,
    approach_speed,
    target_bounds,
    viable_bounds,
)

INF = math.inf
DT = 0.1


def limits(lower=-1.0, upper=1.0, velocity=2.0, acceleration=1.0, jerk=INF):
    return JointLimits(*(np.atleast_1d(x) for x in (lower, upper, velocity, acceleration, jerk)))


def box(q, v, sent=None, **kwargs):
    sent = None if sent is None else np.array([sent])
    bounds = viable_bounds(np.array([q]), limits(**kwargs), DT, np.array([v]), sent)
    return bounds.lower.item(), bounds.upper.item()


# u(d) = -0.1 + sqrt(0.01 + 2 d) for a = 1, dt = 0.1
@pytest.mark.parametrize(
    ("room", "speed"),
    [(0.6, 1.0), (0.0, 0.0), (-0.6, -1.0), (0.105, 0.369041575982), (1e-12, 1e-11)],
)
def test_the_speed_that_still_stops(room, speed):
    result = approach_speed(np.array([room]), np.array([1.0]), DT)
    assert result.item() == pytest.approx(speed, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(
    ("q", "v", "expected"),
    [
        pytest.param(0.0, 0.5, (0.4, 0.6), id="far from all limits the acceleration decides"),
        pytest.param(0.4, 0.95, (0.85, 1.0), id="u(0.6) = 1 cuts what may be added"),
        pytest.param(0.4, 1.1, (1.0, 1.0), id="as fast as one can be and still stop"),
        pytest.param(0.4, 1.5, (1.4, 1.4), id="too fast to stop in time: brakes with a"),
        pytest.param(-0.4, -0.95, (-1.0, -0.85), id="the same towards the lower limit"),
        pytest.param(1.0, 0.0, (-0.1, 0.0), id="at the limit, at rest"),
        pytest.param(1.6, 0.0, (-0.1, -0.1), id="outside, at rest: starts to return with a"),
        pytest.param(1.6, -0.95, (-1.05, -1.0), id="outside: returns at u(-0.6) = -1 or faster"),
        pytest.param(0.0, 3.0, (2.9, 2.9), id="above the velocity limit: brakes with a"),
        pytest.param(
            -9.0, 1.95, (2.0, 2.0), id="outside: returns, but not above the velocity limit"
        ),
    ],
)
def test_a_joint_by_hand(q, v, expected):
    assert box(q, v) == pytest.approx(expected, abs=1e-12)


def test_a_joint_without_position_limits():
    assert box(123.0, 1.95, lower=-INF, upper=INF) == pytest.approx((1.85, 2.0))
    assert box(-1e6, 0.0, lower=-INF, upper=INF) == pytest.approx((-0.1, 0.1))


@pytest.mark.parametrize(
    ("sent", "expected"),
    [
        pytest.param(0.5, (0.4, 0.6), id="it has arrived"),
        pytest.param(0.55, (0.45, 0.6), id="within a of either"),
        pytest.param(0.45, (0.4, 0.55), id="within a of either, from below"),
        pytest.param(0.7, (0.6, 0.6), id="one value is within a of both"),
        pytest.param(0.75, (0.4, 0.6), id="none is: the plant's counts"),
    ],
)
def test_what_was_sent_may_not_have_arrived(sent, expected):
    assert box(0.0, 0.5, sent) == pytest.approx(expected, abs=1e-12)


def test_joints_are_apart_each_on_its_own():
    bounds = viable_bounds(
        np.zeros(3), limits(*(np.full(3, x) for x in (-9, 9, 2, 1, INF))), DT,
        np.array([0.5, 0.5, 0.5]), np.array([0.75, 0.55, 0.25]),
    )  # fmt: skip
    np.testing.assert_allclose(bounds.lower, [0.4, 0.45, 0.4], atol=1e-12)
    np.testing.assert_allclose(bounds.upper, [0.6, 0.6, 0.6], atol=1e-12)
    assert bounds.empty == 0


def test_a_target_has_no_acceleration_box():
    many = limits(*(np.full(4, x) for x in (-1, 1, 2, 1, INF)))
    bounds = target_bounds(np.array([0.0, 0.4, 1.6, -0.4]), many, DT)
    wide = -0.1 + math.sqrt(0.01 + 2.0)
    across = -0.1 + math.sqrt(0.01 + 2.8)
    np.testing.assert_allclose(bounds.lower, [-wide, -across, -2.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(bounds.upper, [wide, 1.0, -1.0, across], atol=1e-12)


def test_bounds_are_read_only_and_count_what_is_empty():
    bounds = viable_bounds(np.zeros(1), limits(), DT, np.zeros(1))
    for side in (bounds.lower, bounds.upper):
        with pytest.raises(ValueError, match="read-only"):
            side[0] = 0.0
    assert Bounds(np.array([0.0, 1.0, np.nan]), np.array([0.0, 0.5, 1.0])).empty == 2


def test_a_number_that_is_none_makes_the_interval_empty():
    for q, v in ((np.nan, 0.0), (0.0, np.nan)):
        assert viable_bounds(np.array([q]), limits(), DT, np.array([v])).empty == 1


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"velocity": [1.0, 1.0, 1.0]}, r"velocity: shape \(3,\), expected \(2,\)"),
        ({"position_upper": [0.0, -2.0]}, r"position_lower\[1\] = -1.0"),
        ({"position_lower": [np.nan, 0.0]}, r"position_lower\[0\]"),
        ({"velocity": [1.0, INF]}, r"velocity\[1\] = inf, must be finite"),
        ({"velocity": [0.0, 1.0]}, r"velocity\[0\]"),
        ({"acceleration": [1.0, -1.0]}, r"acceleration\[1\]"),
        ({"acceleration": [np.nan, 1.0]}, r"acceleration\[0\]"),
        ({"jerk": [0.0, 1.0]}, r"jerk\[0\] = 0.0, must be positive"),
    ],
)
def test_limits_that_make_no_sense_are_refused(fields, words):
    good = limits([-1, -1], [1, 1], [2, 2], [1, 1], [INF, 50.0])
    with pytest.raises(ModelError, match=words):
        replace(good, **{name: np.array(value) for name, value in fields.items()})


def test_limits_are_copies_and_read_only():
    velocity = np.array([2.0])
    kept = limits(velocity=velocity)
    velocity[0] = 5.0
    assert kept.velocity[0] == 2.0
    assert kept.n == 1
    with pytest.raises(ValueError, match="read-only"):
        kept.velocity[0] = 5.0
