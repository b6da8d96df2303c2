"""The levels as arrays: stacked once per solve, with the scale and the kind of their rows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack_core.errors import InputError
from lexstack_core.linear import LinearTask, Matrix, Vector

Signs = NDArray[np.int8]  # -1 at the lower bound, +1 at the upper bound, 0 at neither
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

# Relative to the Frobenius norm of a level: smaller pivots are directions that the level does not
# have. What a level can lose by it is this times its norm and the length of chi.
RANK_TOLERANCE = 1e-7
# In the unit of chi or of a task: what counts as inside. Far above rounding, far below 1e-8.
FEASIBILITY = 1e-11
# The gain of objective per unit of bound below which nothing is felt; rounding makes 1e-15.
MULTIPLIER = 1e-11


@dataclass(slots=True)
class LevelRows:
    """The rows of one level; not frozen, because that would triple the time to make one.

    Attributes:
        matrix: A, shape (m, n).
        lower: shape (m,).
        upper: shape (m,).
        equal: mask of the equality objectives, ``lower == upper``, shape (m,).
        exact: whether all are.
        norm: Frobenius norm of A, positive.
    """

    matrix: Matrix
    lower: Vector
    upper: Vector
    equal: Mask
    exact: bool
    norm: float

    @property
    def tolerance(self) -> float:
        """Below this a pivot of A, or of A reduced to a null space, counts as zero."""
        return RANK_TOLERANCE * self.norm

    def objective(self, sides: Signs) -> tuple[Matrix, Vector, Indices | None]:
        """Return the rows that count as ``A chi -> b``, b, and which they are (None: all).

        Args:
            sides: shape (m,): the end at which an inequality row is held, 0 where it is free;
                equality rows count always.
        """
        if self.exact:
            return self.matrix, self.lower, None
        chosen = np.flatnonzero(self.equal | (sides != 0))
        target = np.where(sides < 0, self.lower, self.upper)
        return self.matrix[chosen], target[chosen], chosen


class Hierarchy:
    """All levels in one array.

    Attributes:
        matrix: shape (M, n).
        lower: shape (M,).
        upper: shape (M,).
        levels: views of the above, index 0 the highest priority.
        equal: mask of the equality objectives, shape (M,).
        ends: the row behind each level's last.
        exact: whether every row is an equality objective.
    """

    def __init__(self, levels: tuple[tuple[LinearTask, ...], ...], n: int) -> None:
        """Stack the tasks; raises InputError if one does not fit chi of length n."""
        tasks = [task for level in levels for task in level]
        for task in tasks:
            _check_shape(task, n)
        if not tasks:
            tasks = [LinearTask("", np.empty((0, n)), np.empty(0), np.empty(0))]
        self.matrix: Matrix = np.concatenate([task.matrix for task in tasks], dtype=float)
        self.lower: Vector = np.concatenate([task.lower for task in tasks], dtype=float)
        self.upper = self.lower
        if any(task.lower is not task.upper for task in tasks):
            self.upper = np.concatenate([task.upper for task in tasks], dtype=float)
        self.equal: Mask = self.lower == self.upper
        self.exact = bool(self.equal.all())
        self.levels: list[LevelRows] = []
        self.ends: list[int] = []
        for level in levels:
            self._add(sum(task.lower.size for task in level))

    def _add(self, count: int) -> None:
        """Append the level of the next ``count`` rows."""
        start = self.ends[-1] if self.ends else 0
        rows = slice(start, start + count)
        matrix, equal = self.matrix[rows], self.equal[rows]
        flat = matrix.reshape(-1)
        exact = self.exact or bool(equal.all())
        norm = math.sqrt(flat.dot(flat)) or 1.0
        self.levels.append(
            LevelRows(matrix, self.lower[rows], self.upper[rows], equal, exact, norm)
        )
        self.ends.append(start + count)

    def residual(self, chi: Vector) -> Vector:
        """Return the signed distance of every row to its interval, shape (M,)."""
        value: Vector = self.matrix.dot(chi)
        nearest = self.lower
        if not self.exact:
            nearest = np.minimum(np.maximum(value, self.lower), self.upper)
        return value - nearest

    def slacks(self, chi: Vector) -> list[float]:
        """Return the norm of each level's residual: NaN or inf where the level is not finite."""
        residual = self.residual(chi)
        slacks = []
        start = 0
        for end in self.ends:
            part = residual[start:end]
            slacks.append(math.sqrt(part.dot(part)))
            start = end
        return slacks


def _check_shape(task: LinearTask, n: int) -> None:
    """Raise InputError if a task's arrays do not fit each other and chi of length n."""
    rows = task.lower.size
    if task.matrix.shape != (rows, n) or task.lower.shape != task.upper.shape:
        raise InputError(
            f"task {task.name}: matrix {task.matrix.shape}, lower {task.lower.shape}, "
            f"upper {task.upper.shape} do not fit chi of length {n}"
        )
