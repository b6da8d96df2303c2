"""The kernel as a solver: one compiled call, and a cascade for what the kernel leaves."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from lexstack.compiled import available
from lexstack.errors import InputError
from lexstack.hqp.backends.daqp import DaqpCascade
from lexstack.hqp.kernel.values import Flags, Places, Signs
from lexstack.hqp.problem import HqpProblem, HqpSolver, Solution, Status
from lexstack.types import LinearTask

Layout = tuple[tuple[tuple[int, bool], ...], ...]
"""By level, of each task: how many rows, and whether they are a Jacobian's."""


class KernelSolver:
    """The strict solver with the compiled kernel; it keeps nothing between solves.

    Problems whose rows or columns need scaling, those without an answer, and the few whose active
    set the kernel does not find, go to another solver, by default the cascade on DAQP.
    """

    name = "kernel"

    def __init__(self, other: HqpSolver | None = None) -> None:
        """Compile the kernel, or load it as it was compiled before: seconds or tenths of one.

        Without numba everything goes to the other solver, with a warning.
        """
        self._other = DaqpCascade() if other is None else other
        self._kernel: Callable[..., bool] = _unsolved
        if available():
            from lexstack.hqp.kernel.exchange import solve  # noqa: PLC0415 - compiles it

            self._kernel = solve
        else:
            warnings.warn(f"numba is not installed: {self._other.name} in its place", stacklevel=2)

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve all levels in order; ``warm`` has the first guess of the active set.

        Raises:
            InputError: a task does not fit chi (a programming error, not a state of the robot).
        """
        start = time.perf_counter()
        # The kernel takes rows that lie one behind the other; most arrays are so already.
        low = np.ascontiguousarray(problem.bounds.lower, dtype=float)
        high = np.ascontiguousarray(problem.bounds.upper, dtype=float)
        n = low.size
        tasks = [task for level in problem.levels for task in level]
        _check(tasks, n)
        if not tasks or not n:
            return self._other.solve(problem, warm)
        ends, curved = _laid_out(
            tuple(
                [
                    tuple([(task.lower.size, task.curve is not None) for task in level])
                    for level in problem.levels
                ]
            )
        )
        matrix = np.concatenate([task.matrix for task in tasks], dtype=float)
        matrix = np.ascontiguousarray(matrix)  # concatenated columns stay columns
        lower = np.concatenate([task.lower for task in tasks], dtype=float)
        upper = lower
        if [task for task in tasks if task.upper is not task.lower]:
            upper = np.concatenate([task.upper for task in tasks], dtype=float)
        held, sides = _guess(warm, n, lower.size)
        chi, slacks = np.empty(n), np.empty(ends.size)
        if not self._kernel(
            matrix, lower, upper, ends, curved, low, high, held, sides, chi, slacks
        ):
            return self._other.solve(problem, warm)
        for array in (chi, slacks, held, sides):
            array.setflags(write=False)
        elapsed = time.perf_counter() - start
        return Solution(chi, slacks, Status.SOLVED, "", held, elapsed, sides)


def _unsolved(*_: object) -> bool:
    """Return what the kernel returns of problems that it leaves."""
    return False


def _check(tasks: list[LinearTask], n: int) -> None:
    """Raise InputError where the arrays of a task do not fit each other and chi of length n."""
    for task in tasks:
        rows = task.lower.size
        if task.matrix.shape != (rows, n) or task.upper.shape != (rows,):
            raise InputError(
                f"task {task.name}: matrix {task.matrix.shape}, lower {task.lower.shape}, "
                f"upper {task.upper.shape} do not fit chi of length {n}"
            )


@lru_cache(maxsize=256)
def _laid_out(layout: Layout) -> tuple[Places, Flags]:
    """Return one past the last row of each level, and which rows are a Jacobian's."""
    sizes = [sum(rows for rows, _ in level) for level in layout]
    curved = [flag for level in layout for rows, flag in level for _ in range(rows)]
    ends, flags = np.cumsum(sizes, dtype=np.int64), np.array(curved, dtype=np.bool_)
    for array in (ends, flags):
        array.setflags(write=False)
    return ends, flags


def _guess(warm: Solution | None, n: int, m: int) -> tuple[Signs, Signs]:
    """Return what the solution before held, as far as it fits."""
    if warm is None or warm.active.size != n:
        return np.zeros(n, dtype=np.int8), np.zeros(m, dtype=np.int8)
    rows = warm.rows.copy() if warm.rows.size == m else np.zeros(m, dtype=np.int8)
    return warm.active.copy(), rows
