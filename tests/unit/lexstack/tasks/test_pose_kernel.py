"""The compiled pose error: the bits of the plain form."""

import os
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest

from lexstack.control.kernels import load_kernels
from lexstack.robots import Pose
from lexstack.tasks import frame_pose, pose_error, saturated
from lexstack.tasks.kernel import pose as kernel

load_kernels()
GAIN, LINEAR, ANGULAR = 3.0, 0.5, 1.0


DIGEST = """
import hashlib
import numpy as np
import pinocchio as pin
from lexstack.tasks.kernel import pose
rng, found = np.random.default_rng(0), hashlib.sha256()
for _ in range(100):
    one, other = (pin.Quaternion(q / np.linalg.norm(q)).matrix() for q in rng.normal(size=(2, 4)))
    error = np.zeros(6)
    pose.pose_error(rng.normal(size=3), one, rng.normal(size=3), other, error)
    found.update(error.tobytes())
print(found.hexdigest())
"""


def poses(rng):
    """Return two poses, some nearly the same, some turned by nearly pi, in several layouts."""
    quaternion = rng.normal(size=4)
    one = pin.Quaternion(quaternion / np.linalg.norm(quaternion)).matrix().copy()
    axis = rng.normal(size=3)
    length = rng.choice([10.0 ** rng.uniform(-9.0, 0.5), np.pi - 10.0 ** rng.uniform(-6.0, -1.0)])
    other = one @ pin.exp3(length * axis / np.linalg.norm(axis))
    if rng.random() < 0.5:
        other = np.asfortranarray(other)
    return Pose(rng.normal(size=3), one), Pose(rng.normal(size=3), other)


def test_the_compiled_error_has_the_bits_of_the_plain_one():
    rng, near_pi = np.random.default_rng(0), 0
    for _ in range(3000):
        one, other = poses(rng)
        expected = frame_pose._pose_error(one, other)
        np.testing.assert_array_equal(pose_error(one, other), expected)
        jacobian = np.asfortranarray(rng.normal(size=(6, 7)))
        matrix, target = np.zeros((6, 12)), np.empty(6)
        places = (one.position, one.rotation, other.position, other.rotation)
        if not kernel.follow(*places, GAIN, LINEAR, ANGULAR, jacobian, 4, matrix, target):
            near_pi += 1
            continue
        np.testing.assert_array_equal(target[:3], saturated(GAIN * expected[:3], LINEAR))
        np.testing.assert_array_equal(target[3:], saturated(GAIN * expected[3:], ANGULAR))
        np.testing.assert_array_equal(matrix[:, 4:11], jacobian)
        assert not matrix[:, :4].any()
        assert not matrix[:, 11:].any()
    assert near_pi > 100
    assert len(kernel.follow.signatures) == len(kernel.pose_error.signatures) == 1


@pytest.mark.parametrize("loaded", [True, False])
def test_near_pi_and_without_numba_the_plain_form_runs(monkeypatch, loaded):
    monkeypatch.setattr(frame_pose, "kernel", lambda _name: kernel if loaded else None)
    one = Pose(np.zeros(3), np.eye(3))
    half = Pose(np.ones(3), np.diag([1.0, -1.0, -1.0]))
    np.testing.assert_allclose(pose_error(one, half), [1.0, 1.0, 1.0, np.pi, 0.0, 0.0])


def test_a_goal_in_whole_numbers_is_taken():
    goal = Pose(np.array([1, 0, 0]), np.eye(3, dtype=int))
    found = pose_error(Pose(np.zeros(3), np.eye(3)), goal)
    np.testing.assert_array_equal(found, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_processors_without_the_instruction_and_python_have_the_same_bits():
    generic = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    found = [
        subprocess.run(
            [sys.executable, "-c", DIGEST],
            env={**os.environ, **extra, "PYTHONPATH": os.pathsep.join(sys.path)},
            capture_output=True,
            text=True,
            check=True,
            timeout=120,
        ).stdout
        for extra in ({}, generic, {"NUMBA_DISABLE_JIT": "1"})
    ]
    assert len(found[0]) > 60
    assert found[0] == found[1] == found[2]
