"""The pose error of a frame, and what closed-loop inverse kinematics asks for, T(16) to T(20)."""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled, entry
from lexstack.robots.kernel.fused import fused
from lexstack.types import Matrix, Vector

_SMALL = 1e-6  # rad, as in ``spatial``
_NEAR_PI = 1e-3  # rad
_VECTOR = "Array(float64, 1, 'A', readonly=True)"
_MATRIX = "Array(float64, 2, 'A', readonly=True)"
_POSES = f"{_VECTOR}, {_MATRIX}, {_VECTOR}, {_MATRIX}"


@compiled
def error_of(position: Vector, rotation: Matrix, goal: Vector, turn: Matrix, error: Vector) -> bool:
    """Set (p_d - p, R log3(R^T R_d)), shape (6,); return False where the angle is near pi.

    Products of matrices are chains as of numpy's ``dot``, see ``fused``.
    """
    if goal.size != 3 or turn.shape != (3, 3):
        raise ValueError("pose_error: the goal is no pose")
    between = np.empty((3, 3))
    for r in range(3):
        for c in range(3):
            value = rotation[0, r] * turn[0, c]
            value = fused(rotation[1, r], turn[1, c], value)
            between[r, c] = fused(rotation[2, r], turn[2, c], value)
    x = between[2, 1] - between[1, 2]
    y = between[0, 2] - between[2, 0]
    z = between[1, 0] - between[0, 1]
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sine, 0.5 * (between[0, 0] + between[1, 1] + between[2, 2] - 1.0))
    if angle < _SMALL:
        factor = 0.5
    elif math.pi - angle > _NEAR_PI:
        factor = 0.5 * angle / sine
    else:
        return False
    x, y, z = factor * x, factor * y, factor * z
    for r in range(3):
        error[r] = goal[r] - position[r]
        value = fused(rotation[r, 0], x, rotation[r, 1] * y)
        error[3 + r] = fused(rotation[r, 2], z, value)
    return True


@compiled
def saturate(vector: Vector, limit: float) -> None:
    """Shorten a vector, shape (3,), to v / sqrt(1 + |v|^2 / limit^2), in place."""
    square = fused(vector[2], vector[2], fused(vector[1], vector[1], vector[0] * vector[0]))
    length = math.sqrt(1.0 + square / (limit * limit))
    for r in range(3):
        vector[r] /= length


@entry(f"boolean({_POSES}, float64[::1])")
def pose_error(
    position: Vector, rotation: Matrix, goal: Vector, turn: Matrix, error: Vector
) -> bool:
    """Set the error of a pose, shape (6,); return whether it was: not so near an angle of pi.

    Args:
        position: p, shape (3,).
        rotation: R, shape (3, 3).
        goal: p_d, shape (3,).
        turn: R_d, shape (3, 3).
        error: (p_d - p, R log3(R^T R_d)), shape (6,).
    """
    return bool(error_of(position, rotation, goal, turn, error))


@entry(
    f"boolean({_POSES}, float64, float64, float64, {_MATRIX}, int64, float64[:, ::1], float64[::1])"
)
def follow(
    position: Vector,
    rotation: Matrix,
    goal: Vector,
    turn: Matrix,
    gain: float,
    linear: float,
    angular: float,
    jacobian: Matrix,
    start: int,
    matrix: Matrix,
    target: Vector,
) -> bool:
    """Set the rows J chi -> sat(K_p e) of a tool; return whether it was done, see ``pose_error``.

    Args:
        position: p, shape (3,).
        rotation: R, shape (3, 3).
        goal: p_d, shape (3,).
        turn: R_d, shape (3, 3).
        gain: K_p.
        linear: limit of the position's part of K_p e.
        angular: limit of the rotation's part.
        jacobian: shape (6, n_robot).
        start: the robot's first column.
        matrix: zero elsewhere, shape (6, n).
        target: sat(K_p e), shape (6,).
    """
    if not error_of(position, rotation, goal, turn, target):
        return False
    for r in range(6):
        target[r] = gain * target[r]
        for c in range(jacobian.shape[1]):
            matrix[r, start + c] = jacobian[r, c]
    saturate(target[:3], linear)
    saturate(target[3:], angular)
    return True
