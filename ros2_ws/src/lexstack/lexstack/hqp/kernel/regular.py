"""Whether levels of one robot, a pose above linear ones, are regular: ``regular.regular_levels``.

The equations are derived there; here they are loops, and the eigenvalues are Jacobi's. Nothing but
a decision comes of it, whose threshold keeps a tenth of distance from the one that counts.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled, entry
from lexstack.hqp.kernel.values import Places
from lexstack.types import Matrix, Vector

# As in ``regular`` and ``lift``, which say why.
MET = 1e-8
SURE = 0.9
TOLD = 0.02
SINGULAR = 0.15
FARTHEST = 0.3
STIFF = 1e4
_SWEEPS = 30  # of Jacobi's method, which squares what is left in each
_OFF = 1e-15  # of the diagonal: what is left beside it counts as zero


@compiled
def cholesky(matrix: Matrix, size: int) -> bool:
    """Replace the lower triangle of a matrix by its factor; return whether it is definite."""
    for i in range(size):
        for j in range(i + 1):
            total = matrix[i, j]
            for c in range(j):
                total -= matrix[i, c] * matrix[j, c]
            if i > j:
                matrix[i, j] = total / matrix[j, j]
            elif total > 0.0:
                matrix[i, i] = math.sqrt(total)
            else:  # also of numbers that are none
                return False
    return True


@compiled
def solve(factor: Matrix, size: int, right: Vector) -> None:
    """Replace a right side, shape (size,), by the solution of L L^T x = b."""
    for i in range(size):
        for c in range(i):
            right[i] -= factor[i, c] * right[c]
        right[i] /= factor[i, i]
    for i in range(size - 1, -1, -1):
        for c in range(i + 1, size):
            right[i] -= factor[c, i] * right[c]
        right[i] /= factor[i, i]


@compiled
def diagonalise(matrix: Matrix, vectors: Matrix) -> None:
    """Turn a symmetric matrix into its eigenvalues on the diagonal; set the eigenvectors."""
    n = matrix.shape[0]
    for i in range(n):
        for j in range(n):
            vectors[i, j] = 1.0 if i == j else 0.0
    for _ in range(_SWEEPS):
        off, on = 0.0, 0.0
        for p in range(n):
            on += abs(matrix[p, p])
            for q in range(p + 1, n):
                off += abs(matrix[p, q])
        if not off > _OFF * on:
            return
        for p in range(n):
            for q in range(p + 1, n):
                if matrix[p, q] == 0.0:
                    continue
                theta = (matrix[q, q] - matrix[p, p]) / (2.0 * matrix[p, q])
                t = 1.0 / (abs(theta) + math.sqrt(theta * theta + 1.0))
                t = -t if theta < 0.0 else t
                c = 1.0 / math.sqrt(t * t + 1.0)
                s = t * c
                for r in range(n):
                    x, y = matrix[r, p], matrix[r, q]
                    matrix[r, p], matrix[r, q] = c * x - s * y, s * x + c * y
                for r in range(n):
                    x, y = matrix[p, r], matrix[q, r]
                    matrix[p, r], matrix[q, r] = c * x - s * y, s * x + c * y
                    x, y = vectors[r, p], vectors[r, q]
                    vectors[r, p], vectors[r, q] = c * x - s * y, s * x + c * y


@compiled
def threshold(gram: Matrix, start: int, end: int, joints: int, size: float, bent: float) -> float:
    """Return the squared singular value above which a level needs nothing: ``_threshold``.

    Args:
        gram: of all rows.
        start: of the level's rows.
        end: one past them.
        joints: of the robot.
        size: of the level's error, over its scale.
        bent: the scale of the first level, of which it is known how it bends; 0 for others.
    """
    squared = SINGULAR * SINGULAR
    if bent == 0.0 or size * joints >= squared:
        return squared
    trace = 0.0
    for i in range(start, end):
        trace += gram[i, i]
    return min(squared, size * (trace / (bent * bent) + joints))


@compiled
def definite_on_joints(rows: Matrix, start: int, end: int, least: float) -> bool:
    """Return whether J^T J + mu A^T A - threshold^2 I is definite, for more rows than joints."""
    n = rows.shape[1]
    tested = np.zeros((n, n))
    for i in range(end):
        factor = STIFF if i < start else 1.0
        for p in range(n):
            if rows[i, p] != 0.0:
                for q in range(p + 1):
                    tested[p, q] += factor * rows[i, p] * rows[i, q]
    for p in range(n):
        tested[p, p] -= least
    return bool(cholesky(tested, n))


@compiled
def bend_along(
    linear: Matrix, unit: float, axes: Matrix, force: Vector, direction: Vector
) -> float:
    """Return d^T B(f) d of a chain, with B as of ``curvature.chain_curvature``.

    Args:
        linear: of the frame's Jacobian, shape (3, n), over ``unit``.
        unit: what makes it the Jacobian.
        axes: shape (3, n).
        force: f and half of t, shape (6,).
        direction: d, shape (n,).
    """
    total = 0.0
    a, b, c = 0.0, 0.0, 0.0  # of the joints before: each pair counts twice
    for j in range(direction.size):
        x, y, z = unit * linear[0, j], unit * linear[1, j], unit * linear[2, j]
        u, v, w = axes[0, j], axes[1, j], axes[2, j]
        one = force[1] * z - force[2] * y + force[4] * w - force[5] * v
        other = force[2] * x - force[0] * z + force[5] * u - force[3] * w
        third = force[0] * y - force[1] * x + force[3] * v - force[4] * u
        d = direction[j]
        along = one * (2.0 * a + d * u) + other * (2.0 * b + d * v)
        total += d * (along + third * (2.0 * c + d * w))
        a, b, c = a + d * u, b + d * v, c + d * w
    return total


@compiled
def bends_little(
    rows: Matrix,
    error: Vector,
    start: int,
    end: int,
    top: int,
    scale: float,
    gram: Matrix,
    axes: Matrix,
    weight: float,
) -> bool:
    """Return whether a level of linear tasks needs no row: ``_bends_little``.

    Args:
        rows: of all levels, shape (m, n).
        error: of the rows, shape (m,).
        start: of the level's rows.
        end: one past them.
        top: one past the rows of the first level, the one that bends.
        scale: of the level.
        gram: of the rows.
        axes: of the frame's Jacobian, shape (3, n).
        weight: sign and scale of the frame's rows.
    """
    n, size = rows.shape[1], end - start
    factor = gram[:start, :start].copy()
    if not cholesky(factor, start):
        return False
    pulled = np.empty((size, start))
    for i in range(size):
        for a in range(start):
            pulled[i, a] = gram[start + i, a]
        solve(factor, start, pulled[i])
    left, vectors = np.empty((size, size)), np.empty((size, size))
    for i in range(size):
        for j in range(size):
            left[i, j] = gram[start + i, start + j]
            for a in range(start):
                left[i, j] -= gram[start + i, a] * pulled[j, a]
    for i in range(size):
        for j in range(i):
            left[i, j] = left[j, i]
    diagonalise(left, vectors)
    length = 0.0
    for i in range(start, end):
        length += error[i] * error[i]
    share = min(1.0, FARTHEST * scale / math.sqrt(length))
    force, direction = np.zeros(6), np.empty(n)
    for a in range(min(top, 6)):
        for i in range(size):
            force[a] -= weight * share * pulled[i, a] * error[start + i]
    for a in range(3, 6):
        force[a] *= 0.5
    for k in range(size):
        square = left[k, k]
        if not square > (TOLD * scale) ** 2:
            return False
        felt = 1.0 - square / (SINGULAR * scale) ** 2
        if felt <= 0.0:
            continue
        for j in range(n):
            direction[j] = 0.0
        for i in range(size):
            factor_of = vectors[i, k] / math.sqrt(square)
            for j in range(n):
                direction[j] += factor_of * rows[start + i, j]
            for a in range(start):
                for j in range(n):
                    direction[j] -= factor_of * pulled[i, a] * rows[a, j]
        if not felt * bend_along(rows[:3], 1.0 / weight, axes, force, direction) <= SURE * square:
            return False
    return True


@entry(
    "boolean(Array(float64, 2, 'C', readonly=True), Array(float64, 1, 'C', readonly=True), "
    "Array(int64, 1, 'C', readonly=True), Array(float64, 1, 'C', readonly=True), "
    "Array(float64, 2, 'A', readonly=True), float64)"
)
def regular(
    rows: Matrix, error: Vector, ends: Places, scales: Vector, axes: Matrix, sign: float
) -> bool:
    """Return whether no level needs a row: a pose first, then levels of linear tasks.

    Args:
        rows: of all levels, on the joints of one robot, shape (m, n).
        error: of the rows, shape (m,).
        ends: one past the last row of each level.
        scales: roots of the weights, by level.
        axes: the angular part of the tool's Jacobian, shape (3, n).
        sign: of the pose's rows.
    """
    m, n = rows.shape
    gram = np.empty((m, m))
    for i in range(m):
        for j in range(i + 1):
            total = 0.0
            for c in range(n):
                total += rows[i, c] * rows[j, c]
            gram[i, j] = gram[j, i] = total
    start = 0
    for k in range(ends.size):
        end, scale = ends[k], scales[k]
        length = 0.0
        for i in range(start, end):
            length += error[i] * error[i]
        size = math.sqrt(length) / scale
        if size <= MET or start == end:
            start = end
            continue
        least = scale * scale * threshold(gram, start, end, n, size, scale if k == 0 else 0.0)
        if end > n:
            if k == 0 or not definite_on_joints(rows, start, end, least):
                return False
            start = end
            continue
        tested = gram[:end, :end].copy()
        for i in range(start, end):
            tested[i, i] -= least
        if not cholesky(tested, end):
            top, weight = ends[0], sign * scales[0]
            if k == 0 or not bends_little(rows, error, start, end, top, scale, gram, axes, weight):
                return False
        start = end
    return True
