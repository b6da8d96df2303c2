"""Rotations against pinocchio's own maps, at every angle up to pi."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexstack.robots import from_quaternion, from_rpy, log3, to_quaternion, wrap

ANGLES = st.one_of(
    st.floats(0.0, np.pi),
    st.sampled_from([0.0, 1e-9, 1e-7, 1e-5, np.pi - 1e-3, np.pi - 1e-6, np.pi - 1e-9, np.pi]),
)
AXES = st.sampled_from(
    [np.eye(3)[0], -np.eye(3)[1], np.eye(3)[2], np.array([1.0, -2.0, 3.0]) / np.sqrt(14.0)]
)


@given(ANGLES, AXES)
def test_log3_is_the_inverse_of_exp(angle, axis):
    rotation = pin.exp3(angle * axis)
    vector = log3(rotation)
    assert np.linalg.norm(vector) <= np.pi + 1e-12
    np.testing.assert_allclose(pin.exp3(vector), rotation, atol=1e-7)


@given(ANGLES, AXES)
def test_quaternions_go_there_and_back(angle, axis):
    rotation = pin.exp3(angle * axis)
    quaternion = to_quaternion(rotation)
    assert abs(np.linalg.norm(quaternion) - 1.0) < 1e-9
    assert quaternion[3] >= -1e-9
    np.testing.assert_allclose(from_quaternion(quaternion), rotation, atol=1e-7)
    np.testing.assert_allclose(pin.Quaternion(quaternion).matrix(), rotation, atol=1e-7)


@given(st.tuples(*[st.floats(-4.0, 4.0)] * 3))
def test_rpy_is_urdf_s(rpy):
    np.testing.assert_allclose(from_rpy(rpy), pin.rpy.rpyToMatrix(*rpy), atol=1e-12)


@pytest.mark.parametrize(
    ("angle", "wrapped"), [(0.0, 0.0), (np.pi, np.pi), (-np.pi, np.pi), (4.0, 4.0 - 2 * np.pi)]
)
def test_wrap(angle, wrapped):
    assert wrap(angle) == pytest.approx(wrapped)
