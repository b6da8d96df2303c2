"""An oracle for strict hierarchies that shares no code and no method with the cascade.

Every level is a bounded least-squares problem for scipy's ``lsq_linear``; what the levels above
demand, A_j chi = A_j chi_j*, enters by the method of multipliers: a penalty, small enough to keep
the problem well conditioned, whose target is shifted until the demand is met exactly. Inequality
rows take a variable each, ``min ||A chi - s||`` with s in [lower, upper].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from lexstack_core.hqp import HqpProblem
from lexstack_core.linear import Matrix, Vector

PENALTY = 1e2
HARDEST = 1e6
ROUNDS = 100
MET = 3e-14


@dataclass(frozen=True)
class OracleLevel:
    """The optimum of one level: its residual norm, and how far the levels above are violated."""

    optimum: float
    violation: float


def lexicographic_oracle(problem: HqpProblem) -> list[OracleLevel]:
    """Return the optimum of every level, given those above it."""
    n = problem.bounds.lower.size
    rows, lower, upper = _lifted(problem, n)
    demands: list[tuple[Matrix, Vector]] = []
    results = []
    for matrix, target in rows:
        x, violation = _solve(matrix, target, demands, lower, upper)
        results.append(OracleLevel(float(np.linalg.norm(matrix @ x - target)), violation))
        demands.append((matrix, matrix @ x))
    return results


def _lifted(problem: HqpProblem, n: int) -> tuple[list[tuple[Matrix, Vector]], Vector, Vector]:
    """Return each level as ``A x -> b`` with one variable more per inequality row."""
    tasks = [(k, task) for k, level in enumerate(problem.levels) for task in level]
    extra = sum(int((task.lower != task.upper).sum()) for _, task in tasks)
    lower, upper = [problem.bounds.lower], [problem.bounds.upper]
    blocks: list[list[tuple[Matrix, Vector]]] = [[] for _ in problem.levels]
    column = n
    for k, task in tasks:
        free = np.flatnonzero(task.lower != task.upper)
        matrix = np.hstack([task.matrix, np.zeros((task.lower.size, extra))])
        target = np.where(task.lower == task.upper, task.lower, 0.0)
        matrix[free, column + np.arange(free.size)] = -1.0
        column += free.size
        lower.append(task.lower[free])
        upper.append(task.upper[free])
        blocks[k].append((matrix, target))
    rows = [
        (np.vstack([m for m, _ in block]), np.concatenate([b for _, b in block]))
        for block in blocks
    ]
    return rows, np.concatenate(lower), np.concatenate(upper)


def _solve(
    matrix: Matrix,
    target: Vector,
    demands: list[tuple[Matrix, Vector]],
    lower: Vector,
    upper: Vector,
) -> tuple[Vector, float]:
    """Return the bounded least-squares point that meets the demands, and by how much it does."""
    if not demands:
        return _bounded(matrix, target, lower, upper), 0.0
    above = np.vstack([m for m, _ in demands])
    wanted = np.concatenate([b for _, b in demands])
    shift, penalty, violation = np.zeros(wanted.size), PENALTY, np.inf
    for _ in range(ROUNDS):
        x = _bounded(
            np.vstack([matrix, penalty * above]),
            np.concatenate([target, penalty * (wanted + shift)]),
            lower,
            upper,
        )
        gap = wanted - above @ x
        shift += gap
        slow = np.abs(gap).max() > 0.3 * violation
        violation = float(np.abs(gap).max())
        if violation < MET:
            break
        if slow and penalty < HARDEST:
            # The shift is a multiplier divided by the squared penalty.
            penalty, shift = 3.0 * penalty, shift / 9.0
    return x, violation


def _bounded(matrix: Matrix, target: Vector, lower: Vector, upper: Vector) -> Vector:
    """Return the bounded least-squares point; raises AssertionError if scipy finds none."""
    fixed = upper - lower < 1e-14
    x = np.where(fixed, lower, 0.0)
    free = np.flatnonzero(~fixed)
    # At ties scipy's BVLS may divide by zero; another order of the variables breaks them.
    for order in (free, free[::-1], np.roll(free, free.size // 2)):
        with np.errstate(divide="ignore", invalid="ignore"):
            result = lsq_linear(
                matrix[:, order],
                target - matrix @ x,
                (lower[order], upper[order]),
                method="bvls",
                tol=1e-15,
                max_iter=2000,
            )
        if result.status > 0 and np.isfinite(result.x).all():
            x[order] = result.x
            return np.clip(x, lower, upper)
    raise AssertionError(f"no oracle: {result.message}")
