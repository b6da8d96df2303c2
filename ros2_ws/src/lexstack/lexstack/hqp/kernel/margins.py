"""What tells whether levels are still far from a singularity: see ``margin`` and ``damping``."""

from __future__ import annotations

import numpy as np

from lexstack.compiled import entry
from lexstack.hqp.kernel.values import Flags
from lexstack.types import Matrix, Vector

_VECTOR = "Array(float64, 1, 'A', readonly=True)"
_MATRIX = "Array(float64, 2, 'A', readonly=True)"


@entry(f"float64({_MATRIX}, {_MATRIX}, int64, int64)")
def squared_change(rows: Matrix, before: Matrix, start: int, stop: int) -> float:
    """Return the squared Frobenius norm of a difference; infinite of matrices of other shapes.

    Args:
        rows: one matrix.
        before: the other one.
        start: of the columns in which they may differ.
        stop: one past the last of them, at most.
    """
    if rows.shape != before.shape:
        return np.inf
    square = 0.0
    for i in range(rows.shape[0]):
        for j in range(start, min(stop, rows.shape[1])):
            change = rows[i, j] - before[i, j]
            square += change * change
    return square


@entry(f"boolean({_VECTOR}, {_VECTOR}, {_VECTOR})")
def stands(position: Vector, upper: Vector, lower: Vector) -> bool:
    """Return whether a joint is beyond one of two positions, shape (n,) each."""
    if not position.size == upper.size == lower.size:
        raise ValueError("stands: the arrays do not fit each other")
    beyond = False
    for j in range(position.size):
        beyond |= position[j] > upper[j] or position[j] < lower[j]
    return beyond


@entry("void(Array(float64, 2, 'C', readonly=True), boolean[::1])")
def columns_of(matrix: Matrix, moved: Flags) -> None:
    """Set which columns of a matrix have an entry that is not zero, shape (n,)."""
    if matrix.shape[1] != moved.size:
        raise ValueError("columns_of: the arrays do not fit each other")
    moved[:] = False
    for i in range(matrix.shape[0]):
        for j in range(moved.size):
            moved[j] |= matrix[i, j] != 0.0
