"""The levels as arrays: stacked once per solve, with the scale and the kind of their rows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError
from lexstack.types import LinearTask, Matrix, Vector

Signs = NDArray[np.int8]
"""-1 at the lower bound, +1 at the upper bound, 0 at neither."""
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

# Relative to the Frobenius norm of a level: smaller pivots are directions that the level does not
# have. What a level can lose by it is this times its norm and the length of chi.
RANK_TOLERANCE = 1e-8
# In the unit of chi, or of a row whose norm is about 1 (`scaling.py` sees to that): how far outside
# an interval still counts as inside, where the numbers are about 1 too. Larger ones have more
# rounding: `noise` says how much.
FEASIBILITY = 1e-11
# Of rows whose norm is about 1: a multiplier below this is zero, where the numbers are about 1.
MULTIPLIER = 1e-11
# Rounding errors of a sum that was made of a few dozen products, relative to their magnitude.
_ROUNDING = 32.0 * float(np.finfo(float).eps)


def noise(magnitude: float) -> float:
    """Return the rounding error of a number that came out of terms of this magnitude."""
    return _ROUNDING * magnitude


@dataclass(slots=True)
class LevelRows:
    """The rows of one level; not frozen, because that would triple the time to make one.

    Attributes:
        rows: which rows of the hierarchy these are.
        matrix: A, shape (m, n).
        lower: shape (m,).
        upper: shape (m,).
        equal: mask of the equality objectives, ``lower == upper``, shape (m,).
        exact: whether all are.
        norm: Frobenius norm of A, positive.
    """

    rows: slice
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


class Hierarchy:
    """All levels in one array.

    Attributes:
        matrix: shape (M, n).
        lower: shape (M,).
        upper: shape (M,).
        levels: views of the above, index 0 the highest priority.
        equal: mask of the equality objectives, shape (M,).
        exact: whether every row is an equality objective.
        deciding: the levels above the first one whose matrix is a multiple of the unit matrix:
            that one uses all freedom, so nothing below it has a say.
        nearest: what that level wants chi to be, shape (n,), or zero: chi is the point next to it
            of those that the deciding levels leave.
        mergeable: how many of the deciding levels have, from the first one on, only equalities and
            together at most n rows.
    """

    __slots__ = (
        "deciding",
        "equal",
        "exact",
        "levels",
        "lower",
        "matrix",
        "mergeable",
        "nearest",
        "upper",
    )

    def __init__(self, levels: tuple[tuple[LinearTask, ...], ...], n: int) -> None:
        """Stack the tasks; raises InputError if one does not fit chi of length n."""
        tasks = [task for level in levels for task in level]
        intervals = _intervals(tasks, n)
        if not tasks:
            tasks = [LinearTask("", np.empty((0, n)), np.empty(0), np.empty(0))]
        self.matrix: Matrix = np.concatenate([task.matrix for task in tasks], dtype=float)
        self.lower: Vector = np.concatenate([task.lower for task in tasks], dtype=float)
        self.upper = self.lower
        self.equal = _all(self.lower.size)
        self.exact = True
        if intervals:
            self.upper = np.concatenate([task.upper for task in tasks], dtype=float)
            self.equal = self.lower == self.upper
            self.exact = bool(self.equal.all())
        self.divide([sum([task.lower.size for task in level]) for level in levels])

    @classmethod
    def of_rows(
        cls,
        rows: tuple[Matrix, Vector, Vector, Mask],
        sizes: list[int],
        parted: frozenset[int],
    ) -> Hierarchy:
        """Return the hierarchy of rows that are stacked already.

        Args:
            rows: matrix, lower and upper ends, and the mask of the equality objectives.
            sizes: how many rows each level has.
            parted: the levels that give way to others, so that no short cut may be taken.
        """
        made = cls.__new__(cls)
        made.matrix, made.lower, made.upper, made.equal = rows
        made.exact = bool(made.equal.all())
        made.divide(sizes, parted)
        made.mergeable = min(made.mergeable, *parted, len(sizes))
        return made

    def divide(self, sizes: list[int], parted: frozenset[int] = frozenset()) -> None:
        """Make the levels of the stacked rows."""
        self.levels: list[LevelRows] = []
        self.deciding: list[LevelRows] = []
        self.nearest: Vector = np.zeros(self.matrix.shape[1])
        self.mergeable = 0
        start, freedom = 0, True
        for size in sizes:
            end = start + size
            added = self._add(slice(start, end))
            freedom = freedom and self._decides(added, len(self.levels) - 1 in parted)
            start = end

    def _add(self, rows: slice) -> LevelRows:
        """Append the level of some rows."""
        matrix, lower, equal = self.matrix[rows], self.lower[rows], self.equal[rows]
        flat = matrix.reshape(-1)
        exact = self.exact or bool(equal.all())
        norm = math.sqrt(flat.dot(flat)) or 1.0
        upper = lower if self.exact else self.upper[rows]
        level = LevelRows(rows, matrix, lower, upper, equal, exact, norm)
        self.levels.append(level)
        return level

    def _decides(self, level: LevelRows, parted: bool) -> bool:
        """Take a level up among the deciding ones; return whether the levels below have a say."""
        rows, n = level.matrix.shape
        scale = unit_scale(level.matrix) if level.exact and rows == n and not parted else 0.0
        if scale:
            self.nearest = level.lower / scale
            return False
        if level.exact and level.rows.stop <= n and self.mergeable == len(self.deciding):
            self.mergeable += 1
        self.deciding.append(level)
        return True

    def residual(self, chi: Vector) -> Vector:
        """Return the signed distance of every row to its interval, shape (M,)."""
        value: Vector = self.matrix.dot(chi)
        nearest = self.lower
        if not self.exact:
            nearest = np.minimum(np.maximum(value, self.lower), self.upper)
        return value - nearest

    def slacks(self, residual: Vector) -> Vector:
        """Return the norm of each level's residual: NaN or inf where the level is not finite."""
        residuals = [residual[level.rows] for level in self.levels]
        return np.array([math.sqrt(one.dot(one)) for one in residuals])

    def active_bounds(self, chi: Vector) -> Signs:
        """Return at which end the inequality rows are, or beyond which, shape (M,)."""
        sides: Signs = np.zeros(self.lower.size, dtype=np.int8)
        if not self.exact:
            value = self.matrix.dot(chi)
            near = max(FEASIBILITY, noise(math.sqrt(chi.dot(chi))))
            sides[value <= self.lower + near] = -1
            sides[value >= self.upper - near] = 1
            sides[self.equal] = 0
        return sides


@lru_cache(maxsize=64)
def _all(size: int) -> Mask:
    """Return a mask of ones, read-only."""
    mask: Mask = np.ones(size, dtype=np.bool_)
    mask.setflags(write=False)
    return mask


def unit_scale(matrix: Matrix) -> float:
    """Return c where a square matrix is c times the unit matrix, else 0."""
    n = len(matrix)
    flat = matrix.reshape(-1)
    first: float = flat.item(0) if n else 0.0
    if first == 0.0 or flat.item(-1) != first or np.count_nonzero(matrix) != n:
        return 0.0
    same = np.count_nonzero(flat[:: n + 1] == first) == n
    return first if same and math.isfinite(first) else 0.0


def _intervals(tasks: list[LinearTask], n: int) -> bool:
    """Return whether a task may have rows whose ends differ.

    Raises:
        InputError: the arrays of a task do not fit each other and chi of length n.
    """
    intervals = False
    for task in tasks:
        rows = task.lower.size
        if task.upper is not task.lower:
            intervals = True
        if task.matrix.shape != (rows, n) or task.upper.shape != (rows,):
            raise InputError(
                f"task {task.name}: matrix {task.matrix.shape}, lower {task.lower.shape}, "
                f"upper {task.upper.shape} do not fit chi of length {n}"
            )
    return intervals
