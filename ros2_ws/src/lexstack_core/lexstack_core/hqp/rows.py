"""A level as arrays: its tasks stacked, its residual, and the rows that count as objectives."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lexstack_core.errors import InputError
from lexstack_core.linear import LinearTask, Matrix, Vector

Signs = NDArray[np.int8]  # -1 at the lower bound, +1 at the upper bound, 0 at neither

# Relative to the Frobenius norm of a level: smaller pivots are directions that the level does not
# have. What a level can lose by it is the tolerance times the length of chi: below 1e-6.
RANK_TOLERANCE = 1e-7
# In the unit of chi or of a task: what counts as inside. Far above rounding, far below 1e-8.
FEASIBILITY = 1e-11
# The gain of objective per unit of bound below which nothing is felt; rounding makes 1e-15.
MULTIPLIER = 1e-11


class LevelRows:
    """The rows of one level, stacked once per solve.

    Attributes:
        matrix: A, shape (m, n).
        lower: shape (m,).
        upper: shape (m,).
        exact: whether every row is an equality objective, ``lower == upper``.
        equal: mask of the equality rows, shape (m,).
        norm: Frobenius norm of A, positive.
        tolerance: below this a pivot of A, or of A reduced to a null space, counts as zero.
    """

    __slots__ = ("equal", "exact", "lower", "matrix", "norm", "tolerance", "upper")

    def __init__(self, tasks: tuple[LinearTask, ...], n: int) -> None:
        """Stack the tasks of a level; raises InputError if one does not fit chi of length n."""
        for task in tasks:
            rows = task.lower.size
            if task.matrix.shape != (rows, n) or task.upper.size != rows:
                raise InputError(
                    f"task {task.name}: matrix {task.matrix.shape}, lower {task.lower.shape}, "
                    f"upper {task.upper.shape} do not fit chi of length {n}"
                )
        self.matrix: Matrix
        self.lower: Vector
        self.upper: Vector
        if len(tasks) == 1:
            self.matrix, self.lower, self.upper = tasks[0].matrix, tasks[0].lower, tasks[0].upper
        elif tasks:
            self.matrix = np.concatenate([task.matrix for task in tasks])
            self.lower = np.concatenate([task.lower for task in tasks])
            self.upper = np.concatenate([task.upper for task in tasks])
        else:
            self.matrix, self.lower, self.upper = np.empty((0, n)), np.empty(0), np.empty(0)
        self.equal = self.lower == self.upper
        self.exact = bool(self.equal.all())
        flat = self.matrix.ravel()
        self.norm = math.sqrt(flat.dot(flat)) or 1.0
        self.tolerance = RANK_TOLERANCE * self.norm

    def residual(self, chi: Vector) -> Vector:
        """Return the signed distance of ``A chi`` to ``[lower, upper]``, shape (m,)."""
        value: Vector = self.matrix.dot(chi)
        if self.exact:
            return value - self.lower
        residual: Vector = value - np.minimum(np.maximum(value, self.lower), self.upper)
        return residual

    def slack(self, chi: Vector) -> float:
        """Return the norm of the residual: NaN or inf where the level is not finite."""
        residual = self.residual(chi)
        return math.sqrt(residual.dot(residual))

    def objective(self, sides: Signs) -> tuple[Matrix, Vector, NDArray[np.intp] | None]:
        """Return the rows that count as ``A chi -> b``, b, and which they are (None: all).

        Args:
            sides: shape (m,): the bound that an inequality row is held at, 0 where it is free;
                equality rows count always.
        """
        if self.exact:
            return self.matrix, self.lower, None
        chosen = np.flatnonzero(self.equal | (sides != 0))
        target = np.where(sides < 0, self.lower, self.upper)
        return self.matrix[chosen], target[chosen], chosen
