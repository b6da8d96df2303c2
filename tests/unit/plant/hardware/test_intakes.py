"""What is measured of arms and platforms, from messages as hardware sends them."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexstack.errors import InputError
from lexstack_plant.hardware.base_intake import BaseIntake, BaseSample, composed, inverse
from lexstack_plant.hardware.joint_intake import JointIntake, JointSample
from lexstack_plant.hardware.sender_clock import SenderClock

NAMES = ("a", "b", "c")
OFFSET = 1000.0  # s, from the sender's clock to ours


def intake(**values):
    return JointIntake(NAMES, np.full(3, 2.0), 0.02, **values)


def sample(q, time, names=NAMES, v=None, late=0.0):
    return JointSample(
        names, list(q), [0.0] * len(q) if v is None else v, time, time + OFFSET + late
    )


# ---- joints


def test_joints_come_in_any_order_with_others_between():
    joints = intake()
    joints.hear(sample([9.0, 3.0, 1.0, 2.0], 1.0, ("x", "c", "a", "b"), [9.0, 0.3, 0.1, 0.2]))
    np.testing.assert_array_equal(joints.q, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(joints.v, [0.1, 0.2, 0.3])
    assert joints.age(1.0 + OFFSET) == pytest.approx(0.0)


def test_a_message_about_others_is_not_looked_at():
    joints = intake()
    joints.hear(sample([np.nan], 1.0, ("x",)))
    assert joints.missing() == list(NAMES)
    assert joints.counters.taken == joints.counters.refused == 0


def test_an_arm_may_come_in_two_messages_and_is_as_old_as_the_older():
    joints = intake()
    joints.hear(sample([1.0, 2.0], 1.0, ("a", "b")))
    assert joints.missing() == ["c"]
    assert joints.age(2.0 + OFFSET) == np.inf
    joints.hear(sample([3.0], 1.5, ("c",)))
    assert joints.age(2.0 + OFFSET) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("q", "v", "names"),
    [
        ([1.0, np.nan, 3.0], None, NAMES),
        ([1.0, 2.0, np.inf], None, NAMES),
        ([1.0, 2.0, 1e9], None, NAMES),
        ([1.0, 2.0, 3.0], [0.0, np.nan, 0.0], NAMES),
        ([1.0, 2.0], None, NAMES),
        ([1.0, 2.0, 3.0], None, ("a", "a", "b")),
    ],
)
def test_what_is_no_sample_is_refused_as_a_whole(q, v, names):
    joints = intake()
    joints.hear(sample([0.1, 0.2, 0.3], 1.0))
    with pytest.raises(InputError, match="joint states"):
        joints.hear(sample(q, 1.01, names, v))
    np.testing.assert_array_equal(joints.q, [0.1, 0.2, 0.3])
    assert joints.counters.refused == 1


def test_repeated_and_late_samples_change_nothing():
    joints = intake()
    joints.hear(sample([0.1, 0.2, 0.3], 1.0))
    joints.hear(sample([0.2, 0.2, 0.3], 1.0))
    joints.hear(sample([0.3, 0.2, 0.3], 0.9))
    np.testing.assert_array_equal(joints.q, [0.1, 0.2, 0.3])
    assert (joints.counters.repeated, joints.counters.late) == (1, 1)
    assert joints.age(1.5 + OFFSET) == pytest.approx(0.5)


def test_velocities_follow_from_positions_where_they_are_missing():
    joints, speed = intake(), np.array([0.5, -0.3, 1.0])
    for k in range(100):
        joints.hear(sample(speed * 0.008 * k, 1.0 + 0.008 * k, v=[]))
    np.testing.assert_allclose(joints.v, speed, rtol=1e-3)


@given(st.lists(st.floats(0.0, 0.05), min_size=20, max_size=60))
def test_a_late_message_has_its_true_age(delays):
    joints, speed = intake(), np.array([0.5, -0.3, 1.0])
    joints.hear(sample(np.zeros(3), 1.0, v=speed))
    for k, late in enumerate(delays, start=1):
        time = 1.0 + 0.01 * k
        joints.hear(sample(0.01 * k * speed, time, v=speed, late=late))
        now = time + OFFSET + late
        np.testing.assert_allclose(joints.at(now, 0.1), (now - OFFSET - 1.0) * speed, atol=1e-9)


def test_a_jump_beyond_the_limits_is_a_fault_until_it_is_forgotten():
    joints = intake()
    joints.hear(sample([0.1, 0.2, 0.3], 1.0))
    joints.hear(sample([0.1 + 2.0 * 0.01, 0.2, 0.3], 1.01))  # at the velocity limit
    assert not joints.fault
    joints.hear(sample([0.12, 0.2 + 0.06, 0.3], 1.02))
    assert joints.fault == "b jumped by 0.06 in 10.0 ms"
    joints.hear(sample([0.12, 0.26, 0.3], 1.03))
    assert joints.fault
    joints.forget()
    joints.hear(sample([0.12, 0.26, 0.3], 1.04))
    assert not joints.fault


def test_without_stamps_the_arrival_counts():
    joints = intake(stamps=False)
    joints.hear(sample([0.1, 0.2, 0.3], 1.0))
    joints.hear(sample([0.11, 0.2, 0.3], 1.0, late=0.01))
    assert joints.counters.taken == 2


@given(st.lists(st.floats(0.0, 0.1), min_size=1, max_size=50), st.floats(-1e9, 1e9))
def test_mapped_stamps_are_never_in_the_future(delays, offset):
    clock = SenderClock()
    for k, delay in enumerate(delays):
        received = 0.01 * k + offset + delay
        assert clock.local(0.01 * k, received) <= received + 1e-6


def test_stamps_of_simulated_time_count_as_they_are():
    joints = intake(shared=True)
    joints.hear(JointSample(NAMES, [0.0] * 3, [], 12.0, 10.0))  # /clock is behind by 2 s
    joints.hear(JointSample(NAMES, [0.0] * 3, [], 12.1, 12.1))
    assert joints.age(12.1) == pytest.approx(0.0)


# ---- platforms


def base(**values):
    return BaseIntake(np.array([1.0, 1.0, 2.0]), 0.02, **values)


def pose(x, y, yaw, time, twist=(0.0, 0.0, 0.0), frame="odom"):
    turn = (0.0, 0.0, sin(0.5 * yaw), cos(0.5 * yaw))
    return BaseSample(x, y, turn, twist, time, time + OFFSET, frame)


def test_the_yaw_of_many_turns_is_unwrapped():
    platform = base()
    for k in range(2000):
        platform.hear(pose(0.0, 0.0, 0.02 * k, 0.02 * k))
    assert platform.q[2] == pytest.approx(0.02 * 1999)
    assert not platform.fault


def test_a_twist_in_base_axes_is_turned_into_the_world():
    platform = base(origin=(1.0, 2.0, pi / 2))
    platform.hear(pose(0.5, 0.0, pi / 2, 1.0, (1.0, 0.0, 0.3)))
    np.testing.assert_allclose(platform.q, [1.0, 2.5, pi])
    np.testing.assert_allclose(platform.v, [-1.0, 0.0, 0.3], atol=1e-12)


def test_a_twist_in_the_axes_of_the_odometry_is_turned_by_its_origin_alone():
    platform = base(origin=(0.0, 0.0, pi / 2), twist_in_base=False)
    platform.hear(pose(0.0, 0.0, 1.0, 1.0, (1.0, 0.0, 0.0)))
    np.testing.assert_allclose(platform.v, [0.0, 1.0, 0.0], atol=1e-12)


def test_a_platform_is_placed_where_it_stands_once():
    platform = base()
    platform.hear(pose(3.0, -1.0, 2.0, 1.0, (0.1, 0.0, 0.0)))
    platform.place((1.0, 1.0, 0.5))
    np.testing.assert_allclose(platform.q, [1.0, 1.0, 0.5])
    np.testing.assert_allclose(platform.v, [0.1 * cos(0.5), 0.1 * sin(0.5), 0.0])
    platform.hear(pose(3.0 + 0.01 * cos(2.0), -1.0 + 0.01 * sin(2.0), 2.0, 1.02))
    np.testing.assert_allclose(platform.q, [1.0 + 0.01 * cos(0.5), 1.0 + 0.01 * sin(0.5), 0.5])
    platform.place((5.0, 5.0, 5.0))
    assert platform.q[0] == pytest.approx(1.0 + 0.01 * cos(0.5))


def test_poses_without_twists_make_velocities():
    platform = base(origin=(0.0, 0.0, 0.0))
    for k in range(100):
        platform.hear(pose(0.01 * k, 0.0, 0.005 * k, 1.0 + 0.02 * k, None))
    np.testing.assert_allclose(platform.v, [0.5, 0.0, 0.25], atol=1e-9)


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (pose(np.nan, 0.0, 0.0, 1.0), "not a number"),
        (pose(1e7, 0.0, 0.0, 1.0), "at 1e"),
        (pose(0.0, 0.0, 0.0, 1.0, (np.inf, 0.0, 0.0)), "not a number"),
        (pose(0.0, 0.0, 0.0, 1.0, frame="map"), "frame 'map', expected 'odom'"),
        (BaseSample(0.0, 0.0, (0.0, 0.0, 0.0, 0.5), None, 1.0, 1.0, "odom"), "norm 0.5"),
        (BaseSample(0.0, 0.0, (sin(0.2), 0.0, 0.0, cos(0.2)), None, 1.0, 1.0, "odom"), "tilted"),
    ],
)
def test_what_is_no_pose_of_a_platform_is_refused(entry, reason):
    platform = base(frame="odom")
    with pytest.raises(InputError, match=reason):
        platform.hear(entry)
    assert platform.counters.refused == 1


def test_jumps_of_a_platform_are_faults():
    platform = base(origin=(0.0, 0.0, 0.0))
    platform.hear(pose(0.0, 0.0, 0.0, 1.0))
    platform.hear(pose(0.1, 0.0, 0.0, 1.02))
    assert platform.fault == "the base jumped by 0.1 m in 20.0 ms"
    platform.forget()
    platform.hear(pose(0.1, 0.0, 0.2, 1.04))
    assert platform.fault == "the base turned by 0.2 rad in 20.0 ms"


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_the_inverse_of_a_pose_undoes_it(place):
    np.testing.assert_allclose(composed(place, inverse(place)), 0.0, atol=1e-12)
