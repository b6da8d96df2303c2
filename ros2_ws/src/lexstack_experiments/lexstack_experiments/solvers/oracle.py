"""An oracle for strict hierarchies that shares no code and no method with the cascade: slow.

Every level is a bounded least-squares problem for scipy's ``lsq_linear``; what the levels above
demand, A_j chi = A_j chi_j*, enters by the method of multipliers: a penalty, small enough to keep
the problem well conditioned, whose target is shifted until the demand is met exactly. Inequality
rows take a variable each, ``min ||A chi - s||`` with s in [lower, upper].
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from lexstack.hqp import (
    Hierarchy,
    HqpProblem,
    Solution,
    Status,
    active_bounds,
    called,
    starting_point,
)
from lexstack.limits import Bounds
from lexstack.types import LinearTask, Matrix, Vector

PENALTY = 1e2
HARDEST = 1e6
ROUNDS = 100
MET = 3e-14
_VIOLATED = 1e-8  # of a level above: more than this is no answer
_OPTIMAL = 1e-8  # of the terms of a gradient: scipy leaves up to 1e-9 where it has arrived
_NEAR = 1e-12  # nearer than this to its bound, a joint is at it
_APART = 1e3  # rows of a level whose norms differ by more are beyond what its penalties resolve
_NOTHING = 1e-13  # of the largest norm: smaller rows are rounding


@dataclass(frozen=True, slots=True)
class OracleLevel:
    """The optimum of one level: its residual norm, and how far the levels above are violated.

    Attributes:
        optimum: norm of the residual.
        violation: largest deviation of a row of the levels above from what they reached, with
            rows of about 1.
        chi: where that is, shape (n,).
    """

    optimum: float
    violation: float
    chi: Vector


class OracleSolver:
    """The oracle as a solver: 10 to 1000 times slower than the others, and independent of them."""

    name = "oracle"

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve all levels in order, then for the smallest ``||chi||``; always cold.

        Raises:
            InputError: a task does not fit chi.
        """
        start = time.perf_counter()
        lower, upper = problem.bounds.lower, problem.bounds.upper
        n = lower.size
        smallest = LinearTask.equality("smallest", np.eye(n), np.zeros(n))
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            hierarchy = Hierarchy(problem.levels, n)
            chi, reason = starting_point(hierarchy, problem)
            if not reason:
                try:
                    levels = lexicographic_oracle(problem, (smallest,))
                except (ArithmeticError, ValueError) as error:
                    levels, reason = [], f"oracle: {error}".splitlines()[0]
                for k, level in enumerate(levels):
                    if not level.violation < _VIOLATED:
                        which = called(k, (*problem.levels, (smallest,))[k])
                        reason = f"{which}: oracle: {level.violation:.2g} off the levels above"
                        break
                    chi = np.minimum(np.maximum(level.chi, lower), upper)
            slacks = hierarchy.slacks(hierarchy.residual(chi))
        active = active_bounds(chi, problem.bounds)
        for array in (chi, slacks, active):
            array.setflags(write=False)
        status = Status.FAILED if reason else Status.SOLVED
        return Solution(chi, slacks, status, reason, active, time.perf_counter() - start)


def lexicographic_oracle(
    problem: HqpProblem, below: tuple[LinearTask, ...] = ()
) -> list[OracleLevel]:
    """Return the optimum of every level, given those above it.

    Args:
        problem: with a box that is not empty.
        below: one level more, if not empty.

    Raises:
        ValueError: scipy finds no optimum, or a number is not finite.
    """
    n = problem.bounds.lower.size
    levels = problem.levels + ((below,) if below else ())
    sizes = [_size(level) for level in levels]
    even = tuple(_divided(level, size) for level, size in zip(levels, sizes, strict=True))
    rows, bounds = _lifted(HqpProblem(even, problem.bounds), n)
    demands: list[tuple[Matrix, Vector]] = []
    results = []
    for (matrix, target), size in zip(rows, sizes, strict=True):
        x, violation = _solve(matrix, target, demands, bounds)
        optimum = size * float(np.linalg.norm(matrix @ x - target))
        results.append(OracleLevel(optimum, violation, x[:n]))
        demands.append((matrix, matrix @ x))
    return results


def _size(level: tuple[LinearTask, ...]) -> float:
    """Return a power of two near the norm of a level's largest row, or 1 where that is usual.

    Raises:
        ValueError: its rows differ too much in size.
    """
    norms = np.concatenate([np.empty(0), *(np.linalg.norm(t.matrix, axis=1) for t in level)])
    norm = float(norms.max(initial=0.0))
    asking = norms[norms > _NOTHING * norm]
    if norm > _APART * asking.min(initial=norm):
        raise ValueError("the rows of a level differ too much in size")
    usual = not np.isfinite(norm) or norm == 0.0 or 1e-2 < norm < 1e2
    return 1.0 if usual else float(np.ldexp(1.0, np.frexp(norm)[1]))


def _divided(level: tuple[LinearTask, ...], size: float) -> tuple[LinearTask, ...]:
    """Return a level in units of ``size``: its penalties and tolerances are then as for others."""
    if size == 1.0:
        return level
    return tuple(
        LinearTask(task.name, task.matrix / size, task.lower / size, task.upper / size)
        for task in level
    )


def _lifted(problem: HqpProblem, n: int) -> tuple[list[tuple[Matrix, Vector]], Bounds]:
    """Return each level as ``A x -> b`` with one variable more per inequality row."""
    tasks = [(k, task) for k, level in enumerate(problem.levels) for task in level]
    extra = sum(int((task.lower != task.upper).sum()) for _, task in tasks)
    lower, upper = [problem.bounds.lower], [problem.bounds.upper]
    blocks: list[list[tuple[Matrix, Vector]]] = [
        [(np.empty((0, n + extra)), np.empty(0))] for _ in problem.levels
    ]
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
    return rows, Bounds(np.concatenate(lower), np.concatenate(upper))


def _solve(
    matrix: Matrix, target: Vector, demands: list[tuple[Matrix, Vector]], bounds: Bounds
) -> tuple[Vector, float]:
    """Return the bounded least-squares point that meets the demands, and by how much it does."""
    if not demands:
        return _bounded(matrix, target, bounds), 0.0
    above = np.vstack([m for m, _ in demands])
    wanted = np.concatenate([b for _, b in demands])
    shift, penalty, violation = np.zeros(wanted.size), PENALTY, np.inf
    for _ in range(ROUNDS):
        x = _bounded(
            np.vstack([matrix, penalty * above]),
            np.concatenate([target, penalty * (wanted + shift)]),
            bounds,
        )
        gap = wanted - above @ x
        shift += gap
        slow = np.abs(gap).max(initial=0.0) > 0.3 * violation
        violation = float(np.abs(gap).max(initial=0.0))
        if violation < MET:
            break
        if slow and penalty < HARDEST:
            # The shift is a multiplier divided by the squared penalty.
            penalty, shift = 3.0 * penalty, shift / 9.0
    return x, violation


def _bounded(matrix: Matrix, target: Vector, bounds: Bounds) -> Vector:
    """Return the bounded least-squares point; raises ValueError if scipy finds none."""
    from scipy.optimize import lsq_linear  # noqa: PLC0415 - 0.4 s, and this is no one's default

    lower, upper = bounds.lower, bounds.upper
    fixed = upper - lower < 1e-14
    x = np.where(fixed, lower, 0.0)
    free = np.flatnonzero(~fixed)
    message = "no joint can move"
    if not free.size or not len(matrix):
        return np.clip(x, lower, upper)
    # scipy begins with a least-squares point that takes rounding for rank, and returns it as solved
    # where it is inside: rows that depend on each other then give anything at all.
    point = np.linalg.lstsq(matrix[:, free], target - matrix @ x, rcond=None)[0]
    if ((point >= lower[free]) & (point <= upper[free])).all():
        x[free] = point
        return x
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
        message = result.message
        if result.status > 0 and np.isfinite(result.x).all():
            found = x.copy()
            found[order] = result.x
            found = np.clip(found, lower, upper)
            if _optimal(matrix, target, bounds, found):
                return found
            message = "scipy's is not optimal"
    raise ValueError(f"no bounded least-squares point: {message}")


def _optimal(matrix: Matrix, target: Vector, bounds: Bounds, x: Vector) -> bool:
    """Return whether no joint that may move has a gradient to follow, up to rounding."""
    gradient = matrix.T @ (matrix @ x - target)
    largest = np.linalg.norm(matrix) * np.linalg.norm(x) + np.linalg.norm(target)
    size = np.linalg.norm(matrix, axis=0) * largest
    near = _NEAR * (1.0 + np.abs(x))
    down = (gradient > _OPTIMAL * size) & (x > bounds.lower + near)
    up = (gradient < -_OPTIMAL * size) & (x < bounds.upper - near)
    return not (down | up).any()
