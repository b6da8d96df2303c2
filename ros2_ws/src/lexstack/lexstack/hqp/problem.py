"""The hierarchical problem and its solution, as values (T(8) to T(15))."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lexstack.limits.joint_limits import Bounds
from lexstack.types import LinearTask, Vector


@dataclass(frozen=True, slots=True)
class HqpProblem:
    """Strictly ordered levels of linear tasks, and the box that chi never leaves.

    Freedom that no level uses is spent on the smallest ``||chi||``: the optimum is unique.

    Attributes:
        levels: index 0 is the highest priority; the tasks of one level are minimised together.
        bounds: box on chi, never relaxed, never empty.
    """

    levels: tuple[tuple[LinearTask, ...], ...]
    bounds: Bounds


class Status(Enum):
    """How a solve ended."""

    SOLVED = "solved"
    FAILED = "failed"


NEAR = "near a singularity"
"""How the line about levels near a singularity begins."""

DAMPED = "damped"
"""What it says of those that are not strict."""

_NAMED = 4  # tasks of a level that a line names


@dataclass(frozen=True, slots=True)
class NearSingular:
    """A level near a singularity.

    Attributes:
        level: index 0 is the highest.
        tasks: names of its tasks, of the robots concerned.
        sigma: the least singular value of its rows in the directions that the levels above leave
            free, in the unit of the rows; 0 where it has more rows than such directions.
        rows: how many were added to it: with any, the level is not strict; see ``lift``.
    """

    level: int
    tasks: str
    sigma: float
    rows: int

    def __str__(self) -> str:
        """Return it in words."""
        damped = f", {DAMPED}" if self.rows else ""
        return f"level {self.level + 1}: {self.tasks} (sigma {self.sigma:.2g}{damped})"


def called(level: int, tasks: Sequence[LinearTask]) -> str:
    """Return a level as users read it: counted from 1, with the names of its tasks.

    Args:
        level: index 0 is the highest.
        tasks: of the level.
    """
    names = [task.name for task in tasks[:_NAMED]]
    more = len(tasks) - len(names)
    return f"level {level + 1} ({' + '.join(names)}{f' and {more} more' if more else ''})"


def near_singularity(near: tuple[NearSingular, ...]) -> str:
    """Return which levels are near a singularity, in one line; empty where none is."""
    return f"{NEAR}: {', '.join(map(str, near))}" if near else ""


def _no_rows() -> NDArray[np.int8]:
    """Return the states of no rows."""
    return np.empty(0, dtype=np.int8)


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver returns; a failure is a value with a reason, never an exception.

    Attributes:
        chi: optimum, shape (n,); on failure the last level that was solved, or the bounds'
            nearest point to zero: always inside the bounds (zero where they hold no number).
        slacks: norm of each level's residual at chi, shape (levels,).
        status: whether every level was solved.
        reason: empty when solved; else one line that names the level and the backend's word.
        active: -1, 0 or +1 per variable of chi: which bound holds (+1 if both), shape (n,).
        solve_time: wall time of the solve [s].
        rows: -1, 0 or +1 per row of all levels, in their order: the end at which, or beyond
            which, an inequality row is; 0 for equality rows; shape (M,). It may be empty.
        note: empty, or which solvers failed before another one solved the problem.
        near: the levels near a singularity; those with added rows gave up strictness to come to
            rest. All others are strict.
        undamped: empty, or why damping could not be worked out, so that there is none.
    """

    chi: Vector
    slacks: Vector
    status: Status
    reason: str
    active: NDArray[np.int8]
    solve_time: float
    rows: NDArray[np.int8] = field(default_factory=_no_rows)
    note: str = ""
    near: tuple[NearSingular, ...] = ()
    undamped: str = ""

    @property
    def solved(self) -> bool:
        """Whether every level was solved."""
        return self.status is Status.SOLVED


class HqpSolver(Protocol):
    """A strict hierarchical solver; one file per backend."""

    name: str

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve all levels in order; ``warm`` is the solution of the tick before, if any."""
        ...


SolverFactory = Callable[[], HqpSolver]
"""Makes a new solver."""
