"""Rotations of all stages at once: logarithm, and how it changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lexstack_core.linear import Matrix
from lexstack_core.rotation import log3

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
