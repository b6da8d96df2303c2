"""Twists of a base: what they drive, that nothing jumps, and that a late one comes to rest."""

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.references import (
    BaseTwist,
    BaseTwistStream,
    Moving,
    References,
    ReferenceSchedule,
    SetPoint,
    Target,
    encode_moving,
)
from lexstack.references.moving import trajectory_of
from lexstack.robots import Pose, Team
from support.differential import driven

START = np.array([1.0, -2.0, 2.5])
STEP = 1e-5  # s
LONG = {"timeout": 5.0}


def begun(value, motion=None, at=1.0, **options):
    motion = SetPoint(START) if motion is None else motion
    return BaseTwistStream.begun(motion, at, BaseTwist(np.array(value), **options))


@pytest.mark.parametrize("turning", [True, False])
def test_its_rate_is_the_derivative_of_its_place(turning):
    first = begun((0.4, -0.2, 1.5), turning=turning, timeout=0.9)
    second = begun((-0.5, 0.3, -2.0), first, 1.7, turning=not turning, timeout=0.5)
    for stream, begin in ((first, 1.0), (second, 1.7)):
        for stamp in np.linspace(begin + STEP, stream.end - STEP, 97):
            moved = stream.at(stamp + STEP) - stream.at(stamp - STEP)
            np.testing.assert_allclose(moved / (2 * STEP), stream.rate(stamp), atol=1e-4)


@pytest.mark.parametrize("turning", [True, False])
def test_neither_place_nor_velocity_jumps_and_it_comes_to_rest(turning):
    first = begun((0.4, -0.2, 1.5), turning=turning, timeout=0.9)
    second = begun((0.1, 0.3, -1.0), first, 1.7, timeout=0.5)
    np.testing.assert_allclose(second.at(1.7), first.at(1.7), atol=1e-12)
    np.testing.assert_allclose(second.rate(1.7), first.rate(1.7), atol=1e-12)
    stamps = np.arange(1.0, second.end + 0.1, 0.001)
    rates = [
        rate if rate is not None else np.zeros(3)
        for rate in ((first if t < 1.7 else second).rate(t) for t in stamps)
    ]
    steps = np.abs(np.diff(rates, axis=0)).max(axis=0) / 0.001
    # Ramps of 1 m/s2 along each axis, and what turning adds: w v.
    assert steps[:2].max() < 1.5 + 1.5 * 0.5
    assert steps[2] < 2.0 + 1e-6
    assert second.rate(second.end) is None
    assert second.at(second.end + 9.0) is second.goal


def test_ahead_while_turning_is_an_arc():
    stream = begun((0.5, 0.0, 1.0), **LONG)
    radius = 0.5
    places = np.array([stream.at(t) for t in np.linspace(2.0, 5.0, 30)])  # behind the ramp
    yaw = places[:, 2]
    centers = places[:, :2] + radius * np.column_stack((-np.sin(yaw), np.cos(yaw)))
    np.testing.assert_allclose(centers, np.broadcast_to(centers[0], centers.shape), atol=1e-12)
    assert np.ptp(yaw) == pytest.approx(3.0)


def test_along_the_axes_of_the_world_it_goes_straight_while_it_turns():
    stream = begun((0.3, 0.0, 1.0), turning=False, **LONG)
    places = np.array([stream.at(t) for t in np.linspace(1.0, 5.0, 30)])
    assert np.ptp(places[:, 1]) == 0.0
    assert np.ptp(places[:, 2]) > 3.0


def test_a_long_ramp_of_a_turning_base_is_integrated_exactly():
    stream = begun((2.0, 0.5, 4.0), linear=1.0, angular=2.0, timeout=3.0)
    fine = np.linspace(1.0, 3.0, 20001)
    rates = np.array([stream.rate(t) for t in fine])
    moved = np.sum(0.5 * (rates[1:] + rates[:-1]), axis=0) * (fine[1] - fine[0])
    np.testing.assert_allclose(stream.at(3.0) - START, moved, atol=1e-7)


def test_numbers_make_the_same_stream_again():
    stream = begun((0.4, -0.2, 1.5), begun((0.1, 0.1, 0.1)), 1.3)
    setting = ReferenceSchedule(References((Pose(np.zeros(3), np.eye(3)),), (START,)), dt=0.01)
    setting.add(Target(0.0, 0, base=stream))
    setting.at(0.0)
    (moving,) = encode_moving(setting.timeline.newest)
    again = trajectory_of(moving, 3, "here")
    for stamp in np.linspace(1.3, stream.end + 0.1, 50):
        np.testing.assert_array_equal(again.at(stamp), stream.at(stamp))


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        (np.zeros(14), "expected 15"),
        (np.zeros(15), "timeout: must be finite and > 0"),
        (np.array([0, 0, 0, 1, 1, 1, 1, 0, *[0] * 6, 0.0]), "the ramp of a twist must last"),
    ],
)
def test_numbers_that_make_none_are_refused(values, reason):
    with pytest.raises(InputError, match=reason):
        trajectory_of(Moving(0, "base", "base_twist", values), 3, "here")


def test_a_posture_has_no_such_twist():
    values = np.array([0, 0, 0, 1, 1, 1, 1, 0, *[0] * 6, 1.0])
    with pytest.raises(InputError, match="only a base"):
        trajectory_of(Moving(0, "posture", "base_twist", values), 7, "here")


def test_a_differential_base_does_not_take_one_to_its_side():
    team = Team((driven(),), 0.01)
    schedule = ReferenceSchedule.at_home(team, team.home())
    schedule.add(Target(0.0, 0, base=BaseTwist(np.array([0.3, 0.0, 0.5]))))
    for value, turning in (((0.3, 0.1, 0.0), True), ((0.3, 0.0, 0.0), False)):
        with pytest.raises(InputError, match="cannot move to its side"):
            schedule.add(Target(0.0, 0, base=BaseTwist(np.array(value), turning)))


@pytest.mark.parametrize("value", [(1.0, 2.0), (1.0, np.nan, 0.0)])
def test_a_value_that_is_none_is_refused(value):
    with pytest.raises(InputError, match="expected 3 finite numbers"):
        BaseTwist(np.array(value))
