"""Rotations: the maps that tasks, messages and the stages of a horizon need.

Quaternions are pinocchio's. The logarithms and the Euler angles stay our own: their last digits
enter chi, and those of all stages are one call.
"""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack.types import Matrix, Vector

_TURN = 2.0 * math.pi  # rad
_SMALL = 1e-6  # rad
_NEAR_PI = 1e-3  # rad
_SMALL_OF_ALL = 1e-4  # rad: the next term of the series is below the last digit
_NEAR_PI_OF_ALL = 1e-2  # rad
_TINY = 1e-12


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


def log3_all(rotations: NDArray[np.float64]) -> Matrix:
    """Return the rotation vectors of rotation matrices, shapes (N, 3, 3) to (N, 3), rad."""
    skew = np.stack(
        (
            rotations[:, 2, 1] - rotations[:, 1, 2],
            rotations[:, 0, 2] - rotations[:, 2, 0],
            rotations[:, 1, 0] - rotations[:, 0, 1],
        ),
        axis=1,
    )
    sine = 0.5 * np.sqrt(np.einsum("ij,ij->i", skew, skew))
    cosine = 0.5 * (rotations[:, 0, 0] + rotations[:, 1, 1] + rotations[:, 2, 2] - 1.0)
    angle = np.arctan2(sine, cosine)
    small = angle < _SMALL_OF_ALL
    divisor = np.where(sine < _TINY, 1.0, sine)  # at zero and at pi, both replaced
    factor = np.where(small, 0.5 + angle * angle / 12.0, 0.5 * angle / divisor)
    vectors = np.asarray(factor[:, None] * skew)
    for k in np.flatnonzero(angle > np.pi - _NEAR_PI_OF_ALL):  # rare, and delicate
        vectors[k] = log3(rotations[k])
    return vectors


def log_slopes(vectors: Matrix) -> NDArray[np.float64]:
    """Return d log(exp(w) R) / dw at w = 0 for rotation vectors log(R), shape (N, 3, 3).

    The inverse of the left Jacobian of SO(3): I - [p]/2 + (1 - (t/2) cot(t/2)) / t^2 [p]^2.
    """
    angle = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    small = angle < _SMALL_OF_ALL
    safe = np.where(small, 1.0, angle)
    half = 0.5 * safe
    factor = np.where(small, 1.0 / 12.0, (1.0 - half / np.tan(half)) / (safe * safe))
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2] = -vectors[:, 2], vectors[:, 1]
    cross[:, 1, 0], cross[:, 1, 2] = vectors[:, 2], -vectors[:, 0]
    cross[:, 2, 0], cross[:, 2, 1] = -vectors[:, 1], vectors[:, 0]
    return np.asarray(np.eye(3) - 0.5 * cross + factor[:, None, None] * (cross @ cross))


def from_quaternion(quaternion: Vector) -> Matrix:
    """Return the rotation matrix of a quaternion (x, y, z, w), which is normalised first."""
    return np.asarray(pin.Quaternion(quaternion / np.linalg.norm(quaternion)).matrix())


def from_quaternions(quaternions: Matrix) -> NDArray[np.float64]:
    """Return rotation matrices of quaternions (x, y, z, w), shapes (N, 4) to (N, 3, 3)."""
    unit = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    return np.array([pin.Quaternion(each).matrix() for each in unit])


def to_quaternion(rotation: Matrix) -> Vector:
    """Return the unit quaternion (x, y, z, w) of a rotation matrix, w >= 0."""
    quaternion = np.array(pin.Quaternion(rotation).coeffs())
    return -quaternion if quaternion[3] < 0.0 else quaternion


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
    wrapped = float(angle) % _TURN
    return wrapped - _TURN if wrapped > math.pi else wrapped


def angles(ones: Matrix, others: Matrix) -> Vector:
    """Return the angles between unit quaternions in R^4, shapes (N, 4) to (N,), rad, in [0, pi].

    Half of the angle of the rotation between them. The tangent has it to the last digit also near
    0 and pi, where the arc cosine of the product loses half of the digits.
    """
    apart = np.linalg.norm(others - ones, axis=-1)
    along = np.linalg.norm(others + ones, axis=-1)
    return np.asarray(2.0 * np.arctan2(apart, along))


def between(ones: Matrix, others: Matrix, shares: Vector) -> Matrix:
    """Return quaternions on the way from one to another (slerp), shapes (N, 4), (N, 4) to (N, 4).

    The rotation turns about one axis, by an angle in proportion to the share, the short way round:

        q(s) = (sin((1 - s) a) q_0 + sin(s a) q_1) / sin a,   a: the angle between them in R^4

    Args:
        ones: q_0, shape (N, 4), of any length but zero.
        others: q_1, shape (N, 4); -q_1 is the same rotation.
        shares: s, shape (N,), in [0, 1]; where s = 0 or the two are equal, the result is q_0.
    """
    first = ones / np.linalg.norm(ones, axis=1, keepdims=True)
    second = others / np.linalg.norm(others, axis=1, keepdims=True)
    near = np.where(np.einsum("ij,ij->i", first, second) < 0.0, -1.0, 1.0)
    second = near[:, None] * second
    angle = angles(first, second)
    still = (shares == 0.0) | (angle < _TINY)
    sine = np.sin(np.where(still, 1.0, angle))
    before, after = np.sin((1.0 - shares) * angle) / sine, np.sin(shares * angle) / sine
    turned = before[:, None] * first + after[:, None] * second
    return np.asarray(np.where(still[:, None], ones, turned))
