"""What is looked at before a solve: does the kernel take it, and which levels decide."""

from __future__ import annotations

import numpy as np

from lexstack.compiled import compiled
from lexstack.hqp.kernel.values import Flags, Rows
from lexstack.types import Vector

_SMALL, _LARGE = 2.0**-8, 2.0**8  # squared norms of rows that are taken as they are; scaling.py
_SPREAD = 1024.0  # ratio of the largest entries of columns that are; columns.py


@compiled
def usable(rows: Rows, curved: Flags, low: Vector, high: Vector) -> bool:
    """Return whether a problem needs no scaling, and no reason why it cannot be solved.

    Args:
        rows: of all levels.
        curved: whether each row is of a Jacobian, whose short rows are directions that it loses.
        low: bounds of chi, shape (n,).
        high: shape (n,).
    """
    n = low.size
    for j in range(n):
        if not (low[j] <= high[j] and low[j] < np.inf and high[j] > -np.inf):
            return False
    jacobians = False
    start = 0
    for end in rows.ends:
        largest = 0.0
        for i in range(start, end):
            if not rows.lower[i] <= rows.upper[i]:
                return False
            if curved[i]:
                jacobians = True
                largest = max(largest, squared(rows, i))
        for i in range(start, end):
            size = largest if curved[i] else squared(rows, i)
            if not (size == 0.0 or _SMALL <= size <= _LARGE):
                return False
        start = end
    return jacobians or alike(rows)


@compiled
def squared(rows: Rows, i: int) -> float:
    """Return the squared norm of a row; infinite where it holds a number that is none."""
    total = 0.0
    for j in range(rows.matrix.shape[1]):
        total += rows.matrix[i, j] * rows.matrix[i, j]
    return total if total < np.inf else np.inf


@compiled
def alike(rows: Rows) -> bool:
    """Return whether the columns are of about one size."""
    least, most = np.inf, 0.0
    for j in range(rows.matrix.shape[1]):
        column = 0.0
        for i in range(rows.matrix.shape[0]):
            column = max(column, abs(rows.matrix[i, j]))
        if column > 0.0:
            least, most = min(least, column), max(most, column)
    return most == 0.0 or most < _SPREAD * least


@compiled
def deciding_levels(rows: Rows, nearest: Vector) -> int:
    """Return how many levels stand above the first one that is c I chi -> b, or all of them.

    That level uses all freedom, so nothing below it has a say.

    Args:
        rows: of all levels.
        nearest: set to b / c, shape (n,); left as it is where there is no such level.
    """
    n = nearest.size
    start = 0
    for k in range(rows.ends.size):
        if rows.ends[k] - start == n and unit(rows, start):
            for j in range(n):
                nearest[j] = rows.lower[start + j] / rows.matrix[start, 0]
            return k
        start = rows.ends[k]
    return rows.ends.size


@compiled
def unit(rows: Rows, start: int) -> bool:
    """Return whether n rows from ``start`` on are equalities and a multiple of the unit matrix."""
    n = rows.matrix.shape[1]
    scale = rows.matrix[start, 0]
    if scale == 0.0:
        return False
    for i in range(n):
        if rows.lower[start + i] != rows.upper[start + i]:
            return False
        for j in range(n):
            if rows.matrix[start + i, j] != (scale if i == j else 0.0):
                return False
    return True
