"""How far a task is from what it asks for."""

from __future__ import annotations

from lexstack.compiled import entry
from lexstack.types import Matrix, Vector

_VECTOR = "Array(float64, 1, 'A', readonly=True)"


@entry(f"float64(Array(float64, 2, 'A', readonly=True), {_VECTOR}, {_VECTOR}, {_VECTOR})")
def square(matrix: Matrix, lower: Vector, upper: Vector, chi: Vector) -> float:
    """Return the squared length of ``LinearTask.residual``.

    Args:
        matrix: shape (m, n).
        lower: shape (m,).
        upper: shape (m,).
        chi: shape (n,).
    """
    if matrix.shape != (lower.size, chi.size) or upper.size != lower.size:
        raise ValueError("square: the arrays do not fit each other")
    total = 0.0
    for i in range(lower.size):
        value, tail = 0.0, chi.size - chi.size % 4
        for j in range(0, tail, 4):  # four at once: a sum of hundreds need not wait for each
            value += (matrix[i, j] * chi[j] + matrix[i, j + 1] * chi[j + 1]) + (
                matrix[i, j + 2] * chi[j + 2] + matrix[i, j + 3] * chi[j + 3]
            )
        for j in range(tail, chi.size):
            value += matrix[i, j] * chi[j]
        value -= min(max(value, lower[i]), upper[i])
        total += value * value
    return total
