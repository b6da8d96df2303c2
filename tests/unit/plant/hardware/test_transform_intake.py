"""The pose of a platform from /tf, and its velocity from odometry or from differences."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from geometry_msgs.msg import TransformStamped
from hypothesis import given
from hypothesis import strategies as st

from lexstack.errors import InputError
from lexstack_config.plant_file import BaseTransformConfig
from lexstack_plant.hardware.base_intake import BaseIntake, BaseSample
from lexstack_plant.hardware.transform_intake import TransformIntake
from lexstack_ros.messages.conversions import to_time

OFFSET = 1000.0  # s, from the sender's clock to ours


def link(parent, child, x, y, yaw, stamp):
    """Return a transform."""
    entry = TransformStamped(child_frame_id=child)
    entry.header.frame_id, entry.header.stamp = parent, to_time(stamp)
    place, turn = entry.transform.translation, entry.transform.rotation
    place.x, place.y, place.z = float(x), float(y), 0.1
    turn.z, turn.w = sin(0.5 * yaw), cos(0.5 * yaw)
    return entry


def intake(**values):
    return TransformIntake(BaseTransformConfig(**values))


def heard(tf, *entries, late=0.0):
    """Return what a message tells."""
    return tf.hear(entries, max(to(e) for e in entries) + OFFSET + late)


def to(entry):
    return entry.header.stamp.sec + 1e-9 * entry.header.stamp.nanosec


def yaw_of(sample):
    return 2.0 * np.arctan2(sample.quaternion[2], sample.quaternion[3])


def test_one_transform_is_the_pose():
    found = heard(intake(), link("odom", "base_link", 1.0, 2.0, 0.5, 3.0))
    assert (found.x, found.y, found.stamp, found.twist) == (1.0, 2.0, 3.0, None)
    assert yaw_of(found) == pytest.approx(0.5)
    assert found.received == 3.0 + OFFSET


def test_transforms_of_others_say_nothing():
    tf = intake()
    assert heard(tf, link("odom", "camera", 1.0, 2.0, 0.5, 3.0)) is None
    assert heard(tf, link("base_link", "wheel", 1.0, 2.0, 0.5, 3.0)) is None


def test_a_chain_has_the_newest_time_that_all_its_links_have():
    tf = intake(parent="map")
    assert heard(tf, link("odom", "base_footprint", 1.0, 0.0, 0.0, 1.0)) is None
    assert tf.hear([link("base_footprint", "base_link", 0.0, 0.2, 0.0, 0.0)], 0.0, static=True) is (
        None
    )
    assert heard(tf, link("odom", "base_footprint", 1.0, 0.0, 0.0, 2.0)) is None
    assert heard(tf, link("map", "odom", 0.0, 5.0, pi / 2, 1.5)) is None  # its first was unheard
    assert heard(tf, link("odom", "base_footprint", 2.0, 0.0, 0.0, 3.0)) is None
    found = heard(tf, link("map", "odom", 0.0, 5.0, pi / 2, 2.5))
    # Half-way between the poses of 2 and 3 s, turned by the map's transform.
    assert found.stamp == 2.5
    np.testing.assert_allclose([found.x, found.y], [-0.2, 6.5], atol=1e-9)
    assert yaw_of(found) == pytest.approx(pi / 2)


def test_a_chain_of_a_message_is_found_at_once():
    tf = intake(parent="map")
    entries = [
        link("odom", "base_link", 1.0, 0.0, 0.0, 1.0),
        link("map", "odom", 3.0, 0.0, 0.0, 1.0),
    ]
    for stamp in (1.0, 1.1):
        for entry in entries:
            entry.header.stamp = to_time(stamp)
        found = heard(tf, *entries)
    assert found.x == pytest.approx(4.0)


def test_a_transform_that_is_none_is_refused():
    tf = intake()
    entry = link("odom", "base_link", np.nan, 0.0, 0.0, 1.0)
    with pytest.raises(InputError, match="between 'base_link' and 'odom' is none"):
        heard(tf, entry)


def test_frames_may_have_a_slash_and_circles_end():
    tf = intake(parent="/odom")
    assert heard(tf, link("/odom", "/base_link", 1.0, 2.0, 0.5, 3.0)).x == 1.0
    tf = intake()
    assert heard(tf, link("a", "base_link", 0.0, 0.0, 0.0, 1.0)) is None
    assert heard(tf, link("base_link", "a", 0.0, 0.0, 0.0, 1.0)) is None


# ---- what a platform makes of it


def platform(**values):
    return BaseIntake(np.array([1.0, 1.0, 2.0]), 0.02, origin=(0.0, 0.0, 0.0), **values)


def fed(base, tf, entry, late=0.0):
    sample = heard(tf, entry, late=late)
    if sample is not None:
        base.hear(sample)


def test_velocities_follow_from_transforms():
    base, tf = platform(), intake()
    for k in range(100):
        fed(base, tf, link("odom", "base_link", 0.01 * k, 0.0, 0.01 * k, 1.0 + 0.02 * k))
    np.testing.assert_allclose(base.v, [0.5, 0.0, 0.5], atol=1e-3)


def test_the_yaw_of_transforms_is_unwrapped():
    base, tf = platform(), intake()
    for k in range(1000):
        fed(base, tf, link("odom", "base_link", 0.0, 0.0, 0.02 * k, 1.0 + 0.02 * k))
    assert base.q[2] == pytest.approx(0.02 * 999)
    assert not base.fault


def test_repeated_and_reordered_transforms_change_nothing():
    base, tf = platform(), intake()
    for stamp, x in ((1.0, 0.0), (1.1, 0.01), (1.1, 0.02), (1.05, 0.03)):
        fed(base, tf, link("odom", "base_link", x, 0.0, 0.0, stamp))
    assert base.q[0] == 0.01
    assert (base.counters.repeated, base.counters.late) == (1, 1)
    fed(base, tf, link("odom", "base_link", 0.02, 0.0, 0.0, 1.2))
    assert base.q[0] == 0.02


def test_a_jump_of_transforms_is_a_fault():
    base, tf = platform(), intake()
    fed(base, tf, link("odom", "base_link", 0.0, 0.0, 0.0, 1.0))
    fed(base, tf, link("odom", "base_link", 0.2, 0.0, 0.0, 1.02))
    assert base.fault == "the base jumped by 0.2 m in 20.0 ms"


def test_transforms_that_end_become_old():
    base, tf = platform(), intake()
    fed(base, tf, link("odom", "base_link", 0.0, 0.0, 0.0, 1.0))
    assert base.age(OFFSET + 1.3) == pytest.approx(0.3)


@given(st.lists(st.floats(0.0, 0.05), min_size=5, max_size=30))
def test_a_late_transform_has_its_true_age(delays):
    base, tf = platform(), intake()
    fed(base, tf, link("odom", "base_link", 0.0, 0.0, 0.0, 1.0))
    for k, late in enumerate(delays, start=1):
        fed(base, tf, link("odom", "base_link", 0.0, 0.0, 0.0, 1.0 + 0.02 * k), late)
        assert base.age(OFFSET + 1.0 + 0.02 * k + late) == pytest.approx(late, abs=1e-6)


# ---- velocities from odometry beside it


def twist(values, stamp, frame="odom"):
    turn = (0.0, 0.0, 0.0, 1.0)
    return BaseSample(9.0, 9.0, turn, values, stamp, stamp + OFFSET, frame)


def test_odometry_beside_transforms_tells_velocities_alone():
    base, tf = platform(twist_apart=True), intake()
    base.hear_twist(twist((0.5, 0.0, 0.1), 1.0))
    assert not base.v.any()  # along which axes is not known yet
    assert base.age(OFFSET + 1.0) == np.inf
    fed(base, tf, link("odom", "base_link", 0.1, 0.0, pi / 2, 1.0))
    base.hear_twist(twist((0.5, 0.0, 0.1), 1.01))
    np.testing.assert_allclose(base.q, [0.1, 0.0, pi / 2])
    np.testing.assert_allclose(base.v, [0.0, 0.5, 0.1], atol=1e-12)
    fed(base, tf, link("odom", "base_link", 0.1, 0.01, pi / 2, 1.02))
    np.testing.assert_allclose(base.v, [0.0, 0.5, 0.1], atol=1e-12)


def test_either_may_become_old():
    base, tf = platform(twist_apart=True), intake()
    fed(base, tf, link("odom", "base_link", 0.0, 0.0, 0.0, 1.0))
    base.hear_twist(twist((0.0, 0.0, 0.0), 1.2))
    assert base.age(OFFSET + 1.3) == pytest.approx(0.3)
    fed(base, tf, link("odom", "base_link", 0.0, 0.0, 0.0, 1.5))
    assert base.age(OFFSET + 1.5) == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("entry", "reason"),
    [(twist((np.nan, 0.0, 0.0), 1.0), "not a number"), (twist((0.0,) * 3, 1.0, "map"), "frame")],
)
def test_a_velocity_that_is_none_is_refused(entry, reason):
    base = platform(twist_apart=True, frame="odom")
    with pytest.raises(InputError, match=reason):
        base.hear_twist(entry)
