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

PENALTY = 1e3
ROUNDS = 200
MET = 1e-12


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
    shift = np.zeros(wanted.size)
    stacked = np.vstack([matrix, PENALTY * above])
    for _ in range(ROUNDS):
        right = np.concatenate([target, PENALTY * (wanted + shift)])
        x = _bounded(stacked, right, lower, upper)
        gap = wanted - above @ x
        shift += gap
        violation = float(np.abs(gap).max())
        if violation < MET:
            break
    return x, violation


def _bounded(matrix: Matrix, target: Vector, lower: Vector, upper: Vector) -> Vector:
    """Return the bounded least-squares point; raises AssertionError if it is none."""
    fixed = upper - lower < 1e-14
    x = np.where(fixed, lower, 0.0)
    free = ~fixed
    result = lsq_linear(
        matrix[:, free],
        target - matrix @ x,
        (lower[free], upper[free]),
        method="bvls",
        tol=1e-15,
        max_iter=2000,
    )
    assert result.status > 0, result.message
    x[free] = result.x
    return np.clip(x, lower, upper)
