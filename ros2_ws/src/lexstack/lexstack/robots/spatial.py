"""Rotations: the few maps that tasks and messages need, exact at angle pi and at zero."""

from __future__ import annotations

import math

import numpy as np

from lexstack.types import Matrix, Vector

_SMALL = 1e-6
_NEAR_PI = 1e-3


def log3(rotation: Matrix) -> Vector:
    """Return the rotation vector of a rotation matrix, shape (3,), rad, norm in [0, pi].

    At angle pi, where the axis has two signs, the one with the first non-zero component positive.
    """
    # Plain numbers: on nine of them numpy takes five times as long.
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation.tolist()
    x, y, z = zy - yz, xz - zx, yx - xy
    trace = xx + yy + zz
    skew = np.array([x, y, z])
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sine, 0.5 * (trace - 1.0))
    if angle < _SMALL:
        return 0.5 * skew
    if math.pi - angle > _NEAR_PI:
        return np.asarray((0.5 * angle / sine) * skew)
    # Near pi the skew part vanishes: the axis comes from R + R^T = 2 cos I + 2 (1 - cos) a a^T.
    symmetric = 0.5 * (rotation + rotation.T) - np.cos(angle) * np.eye(3)
    column = symmetric[:, int(np.argmax(np.diag(symmetric)))]
    axis = column / np.linalg.norm(column)
    if axis @ skew < 0.0 or (sine == 0.0 and axis[np.flatnonzero(np.abs(axis) > _SMALL)[0]] < 0.0):
        axis = -axis
    return np.asarray(angle * axis)


def from_quaternion(quaternion: Vector) -> Matrix:
    """Return the rotation matrix of a quaternion (x, y, z, w), which is normalised first."""
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def to_quaternion(rotation: Matrix) -> Vector:
    """Return the unit quaternion (x, y, z, w) of a rotation matrix, w >= 0."""
    vector = log3(rotation)
    angle = float(np.linalg.norm(vector))
    if angle < _SMALL:
        return np.array([*(0.5 * vector), 1.0])
    return np.array([*(np.sin(0.5 * angle) / angle * vector), np.cos(0.5 * angle)])


def from_rpy(rpy: tuple[float, float, float]) -> Matrix:
    """Return the rotation of roll, pitch, yaw about fixed x, y, z axes [rad], as URDF has it."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def wrap(angle: float) -> float:
    """Return an angle in (-pi, pi] [rad]."""
    wrapped = float(np.remainder(angle, 2.0 * np.pi))
    return wrapped - 2.0 * np.pi if wrapped > np.pi else wrapped
