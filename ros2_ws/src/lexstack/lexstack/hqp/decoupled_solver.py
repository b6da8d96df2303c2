"""Problems of many robots: what no task couples is solved apart and put together again."""

from __future__ import annotations

import time

import numpy as np

from lexstack.hqp.coupling import Structure, Subproblem, share
from lexstack.hqp.problem import HqpProblem, HqpSolver, Solution, Status
from lexstack.limits.joint_limits import Bounds

SIZE = 40  # joints of a subproblem: measured, the cost per joint is least between 20 and 60


class ClusteredSolver:
    """Any solver, with a cost that is linear in the number of robots that no task couples."""

    def __init__(self, inner: HqpSolver, size: int = SIZE) -> None:
        """Solve with ``inner``, in subproblems of at most ``size`` joints if there are any."""
        self.name = inner.name
        self._inner = inner
        self._size = size
        self._structure = Structure(size)

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve all levels in order; each subproblem as if the others were not there.

        Raises:
            InputError: a task does not fit chi (a programming error, not a state of the robot).
        """
        n = problem.bounds.lower.size
        if n <= self._size or not _fits(problem, n):
            return self._inner.solve(problem, warm)
        start = time.perf_counter()
        subproblems = self._structure.subproblems_of(problem)
        if len(subproblems) == 1:
            return self._inner.solve(problem, warm)
        tasks = [task for level in problem.levels for task in level]
        solutions = []
        for subproblem in subproblems:
            levels = tuple(
                [
                    tuple([share(tasks[own.task], own.rows, subproblem.columns) for own in level])
                    for level in subproblem.levels
                ]
            )
            columns = subproblem.columns
            box = Bounds(problem.bounds.lower[columns], problem.bounds.upper[columns])
            solutions.append(self._inner.solve(HqpProblem(levels, box), _warm(warm, subproblem, n)))
        return _together(subproblems, solutions, n, len(problem.levels), start)


def _fits(problem: HqpProblem, n: int) -> bool:
    """Return whether all matrices have n columns; the solver inside says what is wrong."""
    for level in problem.levels:
        for task in level:
            shape = task.matrix.shape
            if len(shape) != 2 or shape[1] != n:
                return False
    return True


def _warm(warm: Solution | None, subproblem: Subproblem, n: int) -> Solution | None:
    """Return what a solution says of a subproblem."""
    if warm is None or warm.active.size != n:
        return None
    columns = subproblem.columns
    rows = warm.rows
    if rows.size:
        rows = rows[subproblem.rows] if rows.size > subproblem.last else rows[:0]
    return Solution(
        warm.chi[columns], warm.slacks, warm.status, warm.reason, warm.active[columns], 0.0, rows
    )


def _together(
    subproblems: tuple[Subproblem, ...],
    solutions: list[Solution],
    n: int,
    levels: int,
    start: float,
) -> Solution:
    """Return the solution of the whole: joints beside each other, residuals as one vector."""
    chi, active = np.empty(n), np.empty(n, dtype=np.int8)
    squares = np.zeros(levels)
    rows = np.zeros(sum([subproblem.rows.size for subproblem in subproblems]), dtype=np.int8)
    reasons, notes = [], []
    for subproblem, solution in zip(subproblems, solutions, strict=True):
        chi[subproblem.columns] = solution.chi
        active[subproblem.columns] = solution.active
        squares += solution.slacks * solution.slacks
        if solution.rows.size:
            rows[subproblem.rows] = solution.rows
        if solution.reason:
            reasons.append(f"{_where(subproblem)}: {solution.reason}")
        if solution.note:
            notes.append(f"{_where(subproblem)}: {solution.note}")
    slacks = np.sqrt(squares)
    for array in (chi, active, slacks, rows):
        array.setflags(write=False)
    status = Status.FAILED if reasons else Status.SOLVED
    elapsed = time.perf_counter() - start
    reason, note = "; ".join(reasons), "; ".join(notes)
    return Solution(chi, slacks, status, reason, active, elapsed, rows, note)


def _where(subproblem: Subproblem) -> str:
    """Return the joints of a subproblem in words; its solver counts them from the first one."""
    if isinstance(subproblem.columns, slice):
        return f"in joints {subproblem.columns.start} to {subproblem.columns.stop - 1}"
    return "in joints " + ", ".join(map(str, subproblem.columns))
