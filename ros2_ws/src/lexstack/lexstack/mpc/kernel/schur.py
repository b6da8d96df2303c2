"""The rows that couple joints: S = A B^-1 A' + D^-1, its Cholesky factor, and solves.

With B block diagonal by joints, and rows A with weights D (of the cost: 1; of a bound that an
interior point method keeps: its z / s; of one that is held: infinite),

    [ B   A'    ] [ d ]   [ f ]
    [ A  -D^-1  ] [ y ] = [ h ]        is        S y = A B^-1 f - h,    d = B^-1 (f - A' y)

A row of one state has coefficients by joint; A B^-1 A' between the rows r of state k and s of state
l is sum_j r_j s_j P_kl of joint j, with P the covariances of ``riccati``. Its order is that of the
rows, 3 N for a tool's position, and it never sees the N n inputs.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.riccati import covariances, respond
from lexstack.mpc.kernel.values import Array, Gains, Qp


@compiled
def assemble(qp: Qp, gains: Gains, inverse: Array, result: Array) -> None:
    """Fill the upper triangle of S; ``inverse`` is the diagonal of D^-1, shape (m + w,)."""
    rows, at = qp.rows, qp.stages
    count, n = rows.shape
    stages = len(qp.gradient)
    spread = np.empty((stages, stages, n))
    covariances(qp.dt, gains, spread)
    scaled = np.empty((n, count))
    for i in range(count):
        if i == 0 or at[i] != at[i - 1]:
            for j in range(n):
                for c in range(i, count):
                    scaled[j, c] = spread[at[i], at[c], j] * rows[c, j]
        for c in range(i, count):
            result[i, c] = 0.0
        for j in range(n):
            own = rows[i, j]
            if own != 0.0:
                for c in range(i, count):
                    result[i, c] += own * scaled[j, c]
        result[i, i] += inverse[i]
    force, motion = np.zeros((3, stages, n)), np.empty((3, stages, n))
    for w in range(len(qp.wide)):
        place = count + w
        force[2] = qp.wide[w]
        respond(qp.dt, gains, force, motion)
        for i in range(count):
            result[i, place] = inner(rows[i], motion[2, at[i]])
        for i in range(w + 1):
            result[count + i, place] = along(qp.wide[i], motion[2])
        result[place, place] += inverse[place]


@compiled
def inner(a: Array, b: Array) -> float:
    """Return a.b, shapes (n,)."""
    total = 0.0
    for j in range(a.size):
        total += a[j] * b[j]
    return total


@compiled
def along(a: Array, b: Array) -> float:
    """Return the sum of a b, shapes (N, n)."""
    total = 0.0
    for k in range(len(a)):
        total += inner(a[k], b[k])
    return total


@compiled
def cholesky(matrix: Array, size: int, least: float) -> bool:
    """Replace the upper triangle of the first rows by R with S = R'R; False: not definite.

    A row at a time, less four of the rows above it in one pass: no sum is reordered.
    """
    for i in range(size):
        row = matrix[i]
        before = row[i]
        k = 0
        while k + 3 < i:
            a, b, c, d = matrix[k, i], matrix[k + 1, i], matrix[k + 2, i], matrix[k + 3, i]
            first, second, third, fourth = matrix[k], matrix[k + 1], matrix[k + 2], matrix[k + 3]
            for j in range(i, size):
                row[j] -= a * first[j] + b * second[j] + c * third[j] + d * fourth[j]
            k += 4
        while k < i:
            a = matrix[k, i]
            above = matrix[k]
            for j in range(i, size):
                row[j] -= a * above[j]
            k += 1
        if not row[i] > least * before:
            return False
        scale = 1.0 / math.sqrt(row[i])
        for j in range(i, size):
            row[j] *= scale
    return True


@compiled
def substitute(factor: Array, size: int, values: Array) -> None:
    """Replace values b by S^-1 b, with the factor of ``cholesky``."""
    forward(factor, size, values)
    backward(factor, size, values)


@compiled
def forward(factor: Array, size: int, values: Array) -> None:
    """Replace values b by R^-T b."""
    for i in range(size):
        row = factor[i]
        value = values[i] / row[i]
        values[i] = value
        for j in range(i + 1, size):
            values[j] -= value * row[j]


@compiled
def backward(factor: Array, size: int, values: Array) -> None:
    """Replace values b by R^-1 b."""
    for i in range(size - 1, -1, -1):
        row = factor[i]
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        j = i + 1
        while j + 3 < size:
            a += row[j] * values[j]
            b += row[j + 1] * values[j + 1]
            c += row[j + 2] * values[j + 2]
            d += row[j + 3] * values[j + 3]
            j += 4
        while j < size:
            a += row[j] * values[j]
            j += 1
        values[i] = (values[i] - ((a + b) + (c + d))) / row[i]


@compiled
def row_values(qp: Qp, positions: Array, result: Array) -> None:
    """Fill A q of all rows, shape (m + w,), for positions of shape (N, n)."""
    count = len(qp.rows)
    for i in range(count):
        result[i] = inner(qp.rows[i], positions[qp.stages[i]])
    for w in range(len(qp.wide)):
        result[count + w] = along(qp.wide[w], positions)


@compiled
def add_rows(qp: Qp, multipliers: Array, scale: float, positions: Array) -> None:
    """Add scale A'y to what acts on the positions, shape (N, n)."""
    count, n = qp.rows.shape
    for i in range(count):
        value = scale * multipliers[i]
        if value != 0.0:
            for j in range(n):
                positions[qp.stages[i], j] += value * qp.rows[i, j]
    for w in range(len(qp.wide)):
        value = scale * multipliers[count + w]
        for k in range(len(positions)):
            for j in range(n):
                positions[k, j] += value * qp.wide[w, k, j]


@compiled
def solve(qp: Qp, gains: Gains, factor: Array, force: Array, right: Array, motion: Array) -> None:
    """Solve the system above: ``motion`` is d with what it leads to, ``right`` h, then y.

    Args:
        qp: with its rows.
        gains: of B.
        factor: of S.
        force: f by inputs, velocities and positions, shape (3, N, n); it is overwritten.
        right: h, shape (m + w,).
        motion: shape (3, N, n).
    """
    size = right.size
    respond(qp.dt, gains, force, motion)
    found = np.empty(size)
    row_values(qp, motion[2], found)
    for i in range(size):
        right[i] = found[i] - right[i]
    substitute(factor, size, right)
    if size:
        add_rows(qp, right, -1.0, force[2])
        respond(qp.dt, gains, force, motion)
