"""Poses and Jacobians of the tools of all robots, joint by joint along each chain.

With the place of joint i on the link before it (R_i, p_i), its motion M(q_i), and the pose before
it, T_i = T_(i-1) (R_i, p_i) M(q_i). The columns of the Jacobian, with z_i the joint's axis and p_i
its origin in the world, and p the tool's:

    turning    [z_i x (p - p_i); z_i]            sliding    [z_i; 0]

Sums are in the order of pinocchio's, whose poses these are to the bit.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lexstack.compiled import compiled, entry
from lexstack.types import Matrix, Vector

_TABLE = "Array({}, 2, 'C', readonly=True)"


@compiled
def turned(rotation: Matrix, axis: int, angle: float) -> None:
    """Turn a rotation, shape (3, 3), about one of its own axes, in place.

    The second of the other axes is the product of the first two, so the rotation stays one.
    """
    c, s = math.cos(angle), math.sin(angle)
    one, other = (axis + 1) % 3, (axis + 2) % 3
    for r in range(3):
        rotation[r, one] = c * rotation[r, one] + s * rotation[r, other]
    for r in range(3):
        p, q = (r + 1) % 3, (r + 2) % 3
        rotation[r, other] = (
            rotation[p, axis] * rotation[q, one] - rotation[q, axis] * rotation[p, one]
        )


@compiled
def product(one: Matrix, other: Matrix, result: Matrix) -> None:
    """Set the product of two rotations, shape (3, 3) each."""
    for c in range(3):
        x, y, z = other[0, c], other[1, c], other[2, c]
        result[0, c] = one[0, 0] * x + one[0, 1] * y + one[0, 2] * z
        result[1, c] = one[1, 0] * x + one[1, 1] * y + one[1, 2] * z
        result[2, c] = one[2, 0] * x + (one[2, 1] * y + one[2, 2] * z)


@compiled
def moved(rotation: Matrix, position: Vector, place: Vector, result: Vector) -> None:
    """Set where a place in a frame is in the world, shape (3,)."""
    x, y, z = place[0], place[1], place[2]
    for r in range(2):
        result[r] = position[r] + (rotation[r, 0] * x + rotation[r, 1] * y + rotation[r, 2] * z)
    result[2] = position[2] + (rotation[2, 0] * x + (rotation[2, 1] * y + rotation[2, 2] * z))


@entry(
    f"void(Array(float64, 1, 'A', readonly=True), {_TABLE.format('int64')}, "
    f"{_TABLE.format('float64')}, {_TABLE.format('int64')}, float64[:, ::1], float64[:, :, ::1], "
    "float64[:, :, ::1])"
)
def tools(
    q: Vector,
    joints: NDArray[np.int64],
    places: Matrix,
    ends: NDArray[np.int64],
    positions: Matrix,
    rotations: NDArray[np.float64],
    jacobians: NDArray[np.float64],
) -> None:
    """Set the tools' poses, and their Jacobians, LOCAL_WORLD_ALIGNED.

    Args:
        q: of all robots.
        joints: of all chains, one after another: whether it slides, its axis, its entry in q, its
            column in the robot's Jacobian.
        places: of each joint on the link before it, and after those the places of the tools: the
            rotation row by row, then the position, shape (., 12).
        ends: of each robot's chain in ``joints``: first, and one past the last.
        positions: of the tools, shape (robots, 3).
        rotations: shape (robots, 3, 3).
        jacobians: transposed, zero at first, shape (robots, most joints, 6).
    """
    if q.size <= joints[:, 2].max():
        raise ValueError("tools: q has another length")
    turns, at = np.empty((joints.shape[0], 3, 3)), np.empty((joints.shape[0], 3))
    own, place = np.empty((3, 3)), np.empty(3)
    for robot in range(ends.shape[0]):
        first, last = ends[robot, 0], ends[robot, 1]
        for i in range(first, last + 1):
            row = i if i < last else joints.shape[0] + robot
            for r in range(3):
                place[r] = places[row, 9 + r]
                for c in range(3):
                    own[r, c] = places[row, 3 * r + c]
            if i < last:
                angle, axis = q[joints[i, 2]], joints[i, 1]
                if joints[i, 0]:
                    for r in range(3):
                        place[r] += own[r, axis] * angle
                else:
                    turned(own, axis, angle)
            rotation = turns[i] if i < last else rotations[robot]
            position = at[i] if i < last else positions[robot]
            if i == first:
                rotation[:], position[:] = own, place
            else:
                product(turns[i - 1], own, rotation)
                moved(turns[i - 1], at[i - 1], place, position)
        for i in range(first, last):
            column, axis = jacobians[robot, joints[i, 3]], joints[i, 1]
            a, b, c = turns[i, 0, axis], turns[i, 1, axis], turns[i, 2, axis]
            if joints[i, 0]:
                column[0], column[1], column[2] = a, b, c
                continue
            x = positions[robot, 0] - at[i, 0]
            y = positions[robot, 1] - at[i, 1]
            z = positions[robot, 2] - at[i, 2]
            column[0], column[1], column[2] = b * z - c * y, c * x - a * z, a * y - b * x
            column[3], column[4], column[5] = a, b, c
