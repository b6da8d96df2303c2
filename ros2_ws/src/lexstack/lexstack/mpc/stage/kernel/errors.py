"""Errors of tasks at one stage and their Jacobians: those of ``lexstack.mpc.measures``.

A rotation is compared with its reference by the rotation vector log(R R_d^T), world axes.
"""

from __future__ import annotations

import math

from lexstack.compiled import compiled
from lexstack.mpc.stage.kernel.chain import slopes
from lexstack.mpc.stage.kernel.values import (
    BASE_POSE,
    COORDINATES,
    KIND,
    ORIENTATION,
    POINT,
    POSE,
    POSITION,
    REFERENCE,
    ROW,
    ROWS,
    Array,
    Chain,
    Places,
    Stages,
    Tasks,
)
from lexstack.types import Matrix, Vector

# As in lexstack.robots.spatial.
_SMALL = 1e-6  # rad
_SMALL_OF_ALL = 1e-4  # rad: the next term of the series is below the last digit
_NEAR_PI = 1e-2  # rad
_TINY = 1e-12


@compiled
def error(tasks: Tasks, t: int, k: int, q: Vector, at: Stages, work: Array, result: Vector) -> None:
    """Write the error of task t at stage k, shape (s,).

    Args:
        tasks: all of them.
        t: which.
        k: the stage.
        q: the coordinates there.
        at: where the points are.
        work: shape (2, 3, 3).
        result: shape (s,).
    """
    layout = tasks.layout[t]
    kind, p, rows = layout[KIND], layout[POINT], layout[ROWS]
    stages = at.points.shape[0]
    columns = rows
    if kind in (POSE, ORIENTATION):
        columns = rows + 1
    begin = layout[REFERENCE] * stages + k * columns
    reference = tasks.references[begin : begin + columns]
    if kind in (POSITION, POSE):
        for a in range(3):
            result[a] = at.points[k, p, a] - reference[a]
    if kind == POSE:
        apart(at.frames[k, p], reference[3:], work, result[3:])
    elif kind == ORIENTATION:
        apart(at.frames[k, p], reference, work, result)
    elif kind in (COORDINATES, BASE_POSE):
        for a in range(rows):
            result[a] = q[tasks.places[layout[ROW] + a]] - reference[a]
        if kind == BASE_POSE:
            result[2] = math.pi - (math.pi - result[2]) % (2.0 * math.pi)


@compiled
def apart(rotation: Matrix, quaternion: Vector, work: Array, result: Vector) -> None:
    """Write log(R R_d^T) for a rotation and a quaternion x, y, z, w, shape (3,)."""
    desired, between = work[0], work[1]
    turned(quaternion, desired)
    for a in range(3):
        for b in range(3):
            total = 0.0
            for c in range(3):
                total += rotation[a, c] * desired[b, c]
            between[a, b] = total
    logarithm(between, result)


@compiled
def turned(quaternion: Vector, result: Matrix) -> None:
    """Write the rotation matrix of a quaternion x, y, z, w, which is normalised first."""
    square = 0.0
    for value in quaternion:
        square += value * value
    length = math.sqrt(square)
    x, y, z = quaternion[0] / length, quaternion[1] / length, quaternion[2] / length
    w = quaternion[3] / length
    result[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    result[0, 1] = 2.0 * (x * y - w * z)
    result[0, 2] = 2.0 * (x * z + w * y)
    result[1, 0] = 2.0 * (x * y + w * z)
    result[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    result[1, 2] = 2.0 * (y * z - w * x)
    result[2, 0] = 2.0 * (x * z - w * y)
    result[2, 1] = 2.0 * (y * z + w * x)
    result[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@compiled
def logarithm(rotation: Matrix, result: Vector) -> None:
    """Write the rotation vector of a rotation matrix, shape (3,), rad, norm in [0, pi]."""
    x = rotation[2, 1] - rotation[1, 2]
    y = rotation[0, 2] - rotation[2, 0]
    z = rotation[1, 0] - rotation[0, 1]
    sine = 0.5 * math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (rotation[0, 0] + rotation[1, 1] + rotation[2, 2] - 1.0)
    angle = math.atan2(sine, cosine)
    if angle < _SMALL_OF_ALL:
        factor = 0.5 + angle * angle / 12.0
    elif sine < _TINY:
        factor = 0.5 * angle
    else:
        factor = 0.5 * angle / sine
    if not angle > math.pi - _NEAR_PI:
        result[0], result[1], result[2] = factor * x, factor * y, factor * z
        return
    # Near pi the skew part vanishes: the axis comes from R + R^T = 2 cos I + 2 (1 - cos) a a^T.
    best = 0
    for a in range(1, 3):
        if rotation[a, a] > rotation[best, best]:
            best = a
    cosine = math.cos(angle)
    square = 0.0
    for a in range(3):
        result[a] = 0.5 * (rotation[a, best] + rotation[best, a])
        if a == best:
            result[a] -= cosine
        square += result[a] * result[a]
    length = math.sqrt(square)
    along = result[0] * x + result[1] * y + result[2] * z
    sign = -1.0 if along < 0.0 else 1.0
    if sine == 0.0:
        for a in range(3):
            if abs(result[a]) > _SMALL * length:
                sign = -1.0 if result[a] < 0.0 else 1.0
                break
    for a in range(3):
        result[a] *= sign * angle / length


@compiled
def log_slope(vector: Vector, result: Matrix) -> None:
    """Write d log(exp(w) R) / dw at w = 0 for the rotation vector log(R), shape (3, 3).

    The inverse of the left Jacobian of SO(3): I - [p]/2 + (1 - (t/2) cot(t/2)) / t^2 [p]^2.
    """
    x, y, z = vector[0], vector[1], vector[2]
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    factor = 1.0 / 12.0
    if not angle < _SMALL_OF_ALL:
        half = 0.5 * angle
        factor = (1.0 - half / math.tan(half)) / (angle * angle)
    # [p]^2 = p p^T - |p|^2 I
    result[0, 0] = 1.0 - factor * (y * y + z * z)
    result[1, 1] = 1.0 - factor * (x * x + z * z)
    result[2, 2] = 1.0 - factor * (x * x + y * y)
    result[0, 1] = 0.5 * z + factor * x * y
    result[1, 0] = -0.5 * z + factor * x * y
    result[0, 2] = -0.5 * y + factor * x * z
    result[2, 0] = 0.5 * y + factor * x * z
    result[1, 2] = 0.5 * x + factor * y * z
    result[2, 1] = -0.5 * x + factor * y * z


@compiled
def jacobian(
    chain: Chain, at: Stages, layout: Places, k: int, found: Vector, work: Array, result: Matrix
) -> int:
    """Write the derivative by q of the error of a task of a frame, shape (s, n_q).

    Args:
        chain: the joints.
        at: where they are.
        layout: of the task.
        k: the stage.
        found: its error there, shape (s,).
        work: shape (2, 3, 3).
        result: shape (6, n_q).

    Returns:
        The first row of the result that belongs to the task.
    """
    kind, p = layout[KIND], layout[POINT]
    if kind == POSITION:
        slopes(chain, at, k, p, result[:3])
        return 0
    slopes(chain, at, k, p, result)
    first = 3 if kind == ORIENTATION else 0
    slant = work[0]
    log_slope(found[3 - first :], slant)
    for c in range(result.shape[1]):
        x, y, z = result[3, c], result[4, c], result[5, c]
        for a in range(3):
            result[3 + a, c] = slant[a, 0] * x + slant[a, 1] * y + slant[a, 2] * z
    return first
