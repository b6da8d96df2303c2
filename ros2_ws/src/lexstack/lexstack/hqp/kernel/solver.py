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
from lexstack.types import Matrix, Vector

_END = -1
"""Ends a level in a layout: of each task twice the rows, and 1 where they are a Jacobian's."""


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
        # Entries must lie one behind the other; most arrays are so already.
        low = np.ascontiguousarray(problem.bounds.lower, dtype=float)
        high = np.ascontiguousarray(problem.bounds.upper, dtype=float)
        n = low.size
        key, matrices, lowers, uppers = _gathered(problem, n)
        if not matrices or not n or high.shape != low.shape:
            return self._other.solve(problem, warm)
        ends, curved = _laid_out(tuple(key))
        # Concatenated columns stay columns: the kernel takes rows that lie one behind the other.
        matrix = np.ascontiguousarray(np.concatenate(matrices, dtype=float))
        upper = lower = np.concatenate(lowers, dtype=float)
        if uppers is not None:
            upper = np.concatenate(uppers, dtype=float)
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


def _gathered(
    problem: HqpProblem, n: int
) -> tuple[list[int], list[Matrix], list[Vector], list[Vector] | None]:
    """Return layout, matrices and ends of all tasks; the upper ends only where some differ.

    Raises:
        InputError: the arrays of a task do not fit each other and chi of length n.
    """
    key: list[int] = []
    matrices, lowers, uppers, equal = [], [], [], True
    for level in problem.levels:
        for task in level:
            matrix, lower, upper = task.matrix, task.lower, task.upper
            rows = lower.size
            if matrix.shape != (rows, n) or upper.shape != (rows,):
                raise InputError(
                    f"task {task.name}: matrix {matrix.shape}, lower {lower.shape}, "
                    f"upper {upper.shape} do not fit chi of length {n}"
                )
            if upper is not lower:
                equal = False
            matrices.append(matrix)
            lowers.append(lower)
            uppers.append(upper)
            key.append(2 * rows if task.curve is None else 2 * rows + 1)
        key.append(_END)
    return key, matrices, lowers, None if equal else uppers


@lru_cache(maxsize=256)
def _laid_out(key: tuple[int, ...]) -> tuple[Places, Flags]:
    """Return one past the last row of each level, and which rows are a Jacobian's."""
    ends, curved = [], list[bool]()
    for number in key:
        if number == _END:
            ends.append(len(curved))
        else:
            curved += [bool(number % 2)] * (number // 2)
    places, flags = np.array(ends, dtype=np.int64), np.array(curved, dtype=np.bool_)
    for array in (places, flags):
        array.setflags(write=False)
    return places, flags


def _guess(warm: Solution | None, n: int, m: int) -> tuple[Signs, Signs]:
    """Return what the solution before held, as far as it fits."""
    if warm is None or warm.active.size != n:
        return np.zeros(n, dtype=np.int8), np.zeros(m, dtype=np.int8)
    rows = warm.rows.copy() if warm.rows.size == m else np.zeros(m, dtype=np.int8)
    return warm.active.copy(), rows
