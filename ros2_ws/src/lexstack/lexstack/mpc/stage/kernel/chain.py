"""Forward kinematics and Jacobians of a tree of joints at all stages, in plain loops.

A joint that turns by t about the unit axis a has in its parent the rotation

    F (a a^T + cos t (I - a a^T) + sin t [a]) = A + cos t B + sin t C,

with F its fixed rotation; A, B and C are made once. A point p on it moves with the joint's velocity
by (R a) x (p - o), or by R a where it slides; R and o are the joint's rotation and origin.
"""

from __future__ import annotations

import math

from lexstack.compiled import compiled, entry
from lexstack.mpc.stage.kernel.values import A3, A4, I1, I2, Array, Chain, M, Places, Stages
from lexstack.types import Matrix, Vector


@compiled
def place(chain: Chain, q: Vector, at: Stages, k: int) -> None:
    """Write where joints, points and frames are at stage k for coordinates q."""
    rotations, origins = at.rotations[k], at.origins[k]
    for j in range(chain.joints.shape[0]):
        parent, turns, column = chain.joints[j, 0], chain.joints[j, 1], chain.joints[j, 2]
        position = chain.fixed[j, 6] * q[column] + chain.fixed[j, 7]
        cosine, sine = 0.0, 0.0
        if turns:
            cosine, sine = math.cos(position), math.sin(position)
        fixed, straight, across = chain.turning[j, 0], chain.turning[j, 1], chain.turning[j, 2]
        for b in range(3):
            x, y, z = fixed[0, b], fixed[1, b], fixed[2, b]
            if turns:
                x += cosine * straight[0, b] + sine * across[0, b]
                y += cosine * straight[1, b] + sine * across[1, b]
                z += cosine * straight[2, b] + sine * across[2, b]
            if parent < 0:
                rotations[j, 0, b], rotations[j, 1, b], rotations[j, 2, b] = x, y, z
            else:
                for a in range(3):
                    row = rotations[parent, a]
                    rotations[j, a, b] = row[0] * x + row[1] * y + row[2] * z
        x, y, z = chain.fixed[j, 0], chain.fixed[j, 1], chain.fixed[j, 2]
        for a in range(3):
            if parent < 0:
                origins[j, a] = chain.fixed[j, a]
            else:
                row = rotations[parent, a]
                origins[j, a] = origins[parent, a] + row[0] * x + row[1] * y + row[2] * z
            if not turns:
                origins[j, a] += position * along(chain, rotations, j, a)
    for p in range(chain.bodies.size):
        body = chain.bodies[p]
        x, y, z = chain.offsets[p, 0], chain.offsets[p, 1], chain.offsets[p, 2]
        for a in range(3):
            if body < 0:
                at.points[k, p, a] = chain.offsets[p, a]
            else:
                row = rotations[body, a]
                at.points[k, p, a] = origins[body, a] + row[0] * x + row[1] * y + row[2] * z
    for p in range(chain.attitudes.shape[0]):
        body, attitude = chain.bodies[p], chain.attitudes[p]
        for a in range(3):
            for b in range(3):
                if body < 0:
                    at.frames[k, p, a, b] = attitude[a, b]
                else:
                    row = rotations[body, a]
                    at.frames[k, p, a, b] = (
                        row[0] * attitude[0, b] + row[1] * attitude[1, b] + row[2] * attitude[2, b]
                    )


@compiled
def along(chain: Chain, rotations: Array, j: int, a: int) -> float:
    """Return coordinate a of a joint's axis in the world."""
    row, axis = rotations[j, a], chain.fixed[j]
    coordinate: float = row[0] * axis[3] + row[1] * axis[4] + row[2] * axis[5]
    return coordinate


@compiled
def slopes(chain: Chain, at: Stages, k: int, p: int, result: Matrix) -> None:
    """Write the derivative of point p by q at stage k; with six rows its body's turning too.

    Args:
        chain: the joints.
        at: where they are.
        k: the stage.
        p: the point.
        result: shape (3, n_q) or (6, n_q), linear then angular, world axes.
    """
    result[:] = 0.0
    rotations, origins = at.rotations[k], at.origins[k]
    j = chain.bodies[p]
    while j >= 0:
        factor, column = chain.fixed[j, 6], chain.joints[j, 2]
        x = factor * along(chain, rotations, j, 0)
        y = factor * along(chain, rotations, j, 1)
        z = factor * along(chain, rotations, j, 2)
        if chain.joints[j, 1]:
            a = at.points[k, p, 0] - origins[j, 0]
            b = at.points[k, p, 1] - origins[j, 1]
            c = at.points[k, p, 2] - origins[j, 2]
            result[0, column] += y * c - z * b
            result[1, column] += z * a - x * c
            result[2, column] += x * b - y * a
            if result.shape[0] > 3:
                result[3, column] += x
                result[4, column] += y
                result[5, column] += z
        else:
            result[0, column] += x
            result[1, column] += y
            result[2, column] += z
        j = chain.joints[j, 0]


@entry(
    f"void({I2}, {A4}, {M}, {I1}, {M}, {A3}, {M}, "
    "float64[:, :, :, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[:, :, :, ::1])"
)
def place_all(
    joints: Places,
    turning: Array,
    fixed: Matrix,
    bodies: Places,
    offsets: Matrix,
    attitudes: Array,
    q: Matrix,
    rotations: Array,
    origins: Array,
    points: Array,
    frames: Array,
) -> None:
    """Write where everything is for the coordinates of all stages, shape (N, n_q); see values."""
    chain = Chain(joints, turning, fixed, bodies, offsets, attitudes)
    at = Stages(rotations, origins, points, frames)
    for k in range(q.shape[0]):
        place(chain, q[k], at, k)


@entry(
    f"void({I2}, {A4}, {M}, {I1}, {M}, {A3}, {A4}, {A3}, {A3}, {A4}, int64, float64[:, :, :, ::1])"
)
def slopes_all(
    joints: Places,
    turning: Array,
    fixed: Matrix,
    bodies: Places,
    offsets: Matrix,
    attitudes: Array,
    rotations: Array,
    origins: Array,
    points: Array,
    frames: Array,
    first: int,
    result: Array,
) -> None:
    """Write the derivatives of successive points, from the first, shape (N, count, 3 or 6, n_q)."""
    chain = Chain(joints, turning, fixed, bodies, offsets, attitudes)
    at = Stages(rotations, origins, points, frames)
    for k in range(result.shape[0]):
        for p in range(result.shape[1]):
            slopes(chain, at, k, first + p, result[k, p])
