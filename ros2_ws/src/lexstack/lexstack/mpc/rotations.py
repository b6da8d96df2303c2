"""Rotations of all stages at once: logarithm, how it changes, and turning between two."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lexstack.robots.spatial import log3
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]
_SMALL = 1e-4
_NEAR_PI = 1e-2
_TINY = 1e-12


def log3_all(rotations: Array) -> Matrix:
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
    small = angle < _SMALL
    divisor = np.where(sine < _TINY, 1.0, sine)  # at zero and at pi, both replaced
    factor = np.where(small, 0.5 + angle * angle / 12.0, 0.5 * angle / divisor)
    vectors = np.asarray(factor[:, None] * skew)
    for k in np.flatnonzero(angle > np.pi - _NEAR_PI):  # rare, and delicate
        vectors[k] = log3(rotations[k])
    return vectors


def log_slopes(vectors: Matrix) -> Array:
    """Return d log(exp(w) R) / dw at w = 0 for rotation vectors log(R), shape (N, 3, 3).

    The inverse of the left Jacobian of SO(3): I - [p]/2 + (1 - (t/2) cot(t/2)) / t^2 [p]^2.
    """
    angle = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    small = angle < _SMALL
    safe = np.where(small, 1.0, angle)
    half = 0.5 * safe
    factor = np.where(small, 1.0 / 12.0, (1.0 - half / np.tan(half)) / (safe * safe))
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2] = -vectors[:, 2], vectors[:, 1]
    cross[:, 1, 0], cross[:, 1, 2] = vectors[:, 2], -vectors[:, 0]
    cross[:, 2, 0], cross[:, 2, 1] = -vectors[:, 1], vectors[:, 0]
    return np.asarray(np.eye(3) - 0.5 * cross + factor[:, None, None] * (cross @ cross))


def from_quaternions(quaternions: Matrix) -> Array:
    """Return rotation matrices of quaternions (x, y, z, w), shapes (N, 4) to (N, 3, 3)."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return np.moveaxis(np.array(rows), 2, 0)


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
