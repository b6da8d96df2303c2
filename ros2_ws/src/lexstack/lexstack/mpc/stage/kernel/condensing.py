"""From derivatives by the states to those by the inputs, of double integrators, in O(N^2).

A position q_k moves with the input u_l by dt^2 (k - l - 1/2), l < k. In stages, from the last one
m of two inputs l <= m on, both ages are x = k - m - 1/2 and x + (m - l). So with the sums

    S_m = sum_(k > m) B_k     T_m = sum_(k > m) x B_k     U_m = sum_(k > m) x^2 B_k,

which follow from those of m + 1 (every x grows by 1), the block of the Hessian of l and m is

    dt^4 (U_m + (m - l) T_m),

and that of the velocities dt^2 sum_(k > m) V_k. Gradients have S and T of vectors.
"""

from __future__ import annotations

import numpy as np

from lexstack.compiled import entry
from lexstack.mpc.stage.kernel.values import A3, Array, M
from lexstack.types import Matrix


@entry(f"void({M}, {A3}, float64, float64[:, ::1])")
def condense_gradient(slant: Matrix, forces: Array, step: float, gradient: Matrix) -> None:
    """Write the gradient by the inputs.

    Args:
        slant: by the positions, shape (N, n).
        forces: by velocities and inputs, shape (2, N, n).
        step: s.
        gradient: shape (N, n); written.
    """
    stages, n = slant.shape
    for j in range(n):
        total, aged, speed = 0.0, 0.0, 0.0
        for m in range(stages - 1, -1, -1):
            aged += total + 0.5 * slant[m, j]
            total += slant[m, j]
            speed += forces[0, m, j]
            gradient[m, j] = step * (step * aged + speed) + forces[1, m, j]


@entry(f"void({A3}, {A3}, {M}, float64, float64[:, ::1])")
def condense_hessian(
    curved: Array, stiffness: Array, effort: Matrix, step: float, hessian: Matrix
) -> None:
    """Write the Hessian by the inputs.

    Args:
        curved: by the positions, shape (N, n, n), symmetric.
        stiffness: diagonals by positions, velocities and inputs, shape (3, N, n).
        effort: weights of velocity, input and its change, shape (3, n).
        step: s.
        hessian: shape (N n, N n), by stage and joint; written.
    """
    stages, n = curved.shape[0], curved.shape[1]
    total, aged, twice = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    speeds = np.zeros(n)
    square = step * step
    fourth = square * square
    for m in range(stages - 1, -1, -1):
        for a in range(n):
            for b in range(n):
                here = curved[m, a, b]
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
