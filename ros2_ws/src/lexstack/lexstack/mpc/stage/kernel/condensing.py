"""From derivatives by the states to those by the inputs, in O(N^2) for double integrators.

A position q_k moves with the input u_l by dt^2 (k - l - 1/2), l < k. In stages, from the last one
m of two inputs l <= m on, both ages are x = k - m - 1/2 and x + (m - l). So with the sums

    S_m = sum_(k > m) B_k     T_m = sum_(k > m) x B_k     U_m = sum_(k > m) x^2 B_k,

which follow from those of m + 1 (every x grows by 1), the block of the Hessian of l and m is

    dt^4 (U_m + (m - l) T_m),

and that of the velocities dt^2 sum_(k > m) V_k. Gradients have S and T of vectors.

Of a differential base, x and y follow the first two inputs by D_k, the ``drive``, and the
coordinates from the third one on are the positions of the inputs from the second one on. With C_k
for these, the Hessian is sum (C_k + D_k)^T B_k (C_k + D_k): the products with one D_k are sums
T of vectors again, those with two are added term by term. Without such a base ``drive`` has no
stages.
"""

from __future__ import annotations

import numpy as np

from lexstack.compiled import compiled, entry
from lexstack.mpc.stage.kernel.values import A3, A4, Array, M
from lexstack.types import Matrix


@compiled
def add_mixed(curved: Array, drive: Array, square: float, n: int, hessian: Matrix) -> None:
    """Add sum D_k^T B_k C_k and its transpose."""
    stages = drive.shape[0]
    for i in range(stages):
        for d in range(2):
            row = i * n + d
            for b in range(1, n):
                total, aged = 0.0, 0.0
                for m in range(stages - 1, -1, -1):
                    here = (
                        drive[m, 0, i, d] * curved[m, 0, 1 + b]
                        + drive[m, 1, i, d] * curved[m, 1, 1 + b]
                    )
                    aged += total + 0.5 * here
                    total += here
                    hessian[row, m * n + b] += square * aged
                    hessian[m * n + b, row] += square * aged


@compiled
def add_driven(curved: Array, stiffness: Array, drive: Array, n: int, hessian: Matrix) -> None:
    """Add sum D_k^T B_k D_k."""
    stages = drive.shape[0]
    for j in range(stages):
        for e in range(2):
            column = j * n + e
            for k in range(j, stages):
                x, y = drive[k, 0, j, e], drive[k, 1, j, e]
                along = curved[k, 0, 0] * x + curved[k, 0, 1] * y
                across = curved[k, 1, 0] * x + (curved[k, 1, 1] + stiffness[0, k, 0]) * y
                for i in range(j + 1):
                    for d in range(2):
                        value = drive[k, 0, i, d] * along + drive[k, 1, i, d] * across
                        hessian[i * n + d, column] += value
                        if i < j:
                            hessian[column, i * n + d] += value


@entry(f"void({M}, {A3}, {A4}, float64, float64[:, ::1])")
def condense_gradient(
    slant: Matrix, forces: Array, drive: Array, step: float, gradient: Matrix
) -> None:
    """Write the gradient by the inputs.

    Args:
        slant: by the positions, shape (N, n_q).
        forces: by velocities and inputs, shape (2, N, n).
        drive: shape (N, 2, N, 2); without stages: no differential base.
        step: s.
        gradient: shape (N, n); written.
    """
    stages, n = gradient.shape
    first = slant.shape[1] - n
    for j in range(n):
        total, aged, speed = 0.0, 0.0, 0.0
        for m in range(stages - 1, -1, -1):
            here = slant[m, first + j] if j >= first else 0.0
            aged += total + 0.5 * here
            total += here
            speed += forces[0, m, j]
            gradient[m, j] = step * (step * aged + speed) + forces[1, m, j]
    for k in range(drive.shape[0]):
        for j in range(k + 1):
            for d in range(2):
                gradient[j, d] += slant[k, 0] * drive[k, 0, j, d] + slant[k, 1] * drive[k, 1, j, d]


@entry(f"void({A3}, {A4}, float64, float64[:, :, :, ::1])")
def condense_rows(slopes: Array, drive: Array, step: float, rows: Array) -> None:
    """Write rows in the inputs.

    Args:
        slopes: rows in the positions of each state, shape (N, r, n_q).
        drive: shape (N, 2, N, 2); without stages: no differential base.
        step: s.
        rows: shape (N, r, N, n); written.
    """
    stages, count, n = rows.shape[0], rows.shape[1], rows.shape[3]
    first = slopes.shape[2] - n
    rows[:] = 0.0
    for k in range(stages):
        for r in range(count):
            for l in range(k + 1):  # noqa: E741 - the symbol of the equations
                age = step * step * (k - l + 0.5)
                for j in range(first, n):
                    rows[k, r, l, j] = age * slopes[k, r, first + j]
                if first:
                    for d in range(2):
                        rows[k, r, l, d] += (
                            slopes[k, r, 0] * drive[k, 0, l, d]
                            + slopes[k, r, 1] * drive[k, 1, l, d]
                        )


@entry(f"void({A3}, {A3}, {M}, {A4}, float64, float64[:, ::1])")
def condense_hessian(
    curved: Array, stiffness: Array, effort: Matrix, drive: Array, step: float, hessian: Matrix
) -> None:
    """Write the Hessian by the inputs.

    Args:
        curved: by the positions, shape (N, n_q, n_q), symmetric.
        stiffness: diagonals by positions (the last n), velocities and inputs, shape (3, N, n).
        effort: weights of velocity, input and its change, shape (3, n).
        drive: shape (N, 2, N, 2); without stages: no differential base.
        step: s.
        hessian: shape (N n, N n), by stage and joint; written.
    """
    stages, n = stiffness.shape[1], stiffness.shape[2]
    first = curved.shape[1] - n
    total, aged, twice = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    speeds = np.zeros(n)
    square = step * step
    fourth = square * square
    for m in range(stages - 1, -1, -1):
        for a in range(n):
            for b in range(n):
                here = 0.0
                if a >= first and b >= first:
                    here = curved[m, first + a, first + b]
                    if a == b:
                        here += stiffness[0, m, a]
                twice[a, b] += 2.0 * aged[a, b] + total[a, b] + 0.25 * here
                aged[a, b] += total[a, b] + 0.5 * here
                total[a, b] += here
            speeds[a] += stiffness[1, m, a] + effort[0, a]
        for a in range(n):
            row = m * n + a
            for l in range(m + 1):  # noqa: E741 - the symbol of the equations
                mirrored = l * n + a  # a block is symmetric, so its mirror image has the same rows
                back = float(m - l)
                for b in range(n):
                    value = fourth * (twice[a, b] + back * aged[a, b])
                    hessian[row, l * n + b] = value
                    hessian[mirrored, m * n + b] = value
                value = hessian[row, mirrored] + square * speeds[a]
                if l == m:
                    value += stiffness[2, m, a] + effort[1, a] + effort[2, a]
                    if m + 1 < stages:
                        value += effort[2, a]
                elif l == m - 1:
                    value -= effort[2, a]
                hessian[row, mirrored] = value
                hessian[mirrored, row] = value
    if first:
        add_mixed(curved, drive, square, n, hessian)
        add_driven(curved, stiffness, drive, n, hessian)
