"""Linear tasks on chi: the rows that a task contributes to a level of the hierarchy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LinearTask:
    """One task made linear at the present state: ``lower <= matrix @ chi <= upper``.

    Rows with ``lower == upper`` are the equality objective ``A chi -> b`` of T(8); the others are
    inequality objectives, +-inf allowed on one side. The residual of a row is its distance to
    ``[lower, upper]``; a level minimises the sum of squared residuals of its tasks.

    Attributes:
        name: unique within its stack, e.g. ``robot_a/ee_pose``.
        matrix: A, shape (m, n) with n the length of chi.
        lower: shape (m,), in the unit of ``matrix @ chi``.
        upper: shape (m,), ``lower <= upper``.
    """

    name: str
    matrix: Matrix
    lower: Vector
    upper: Vector

    @classmethod
    def equality(cls, name: str, matrix: Matrix, target: Vector) -> LinearTask:
        """Return the task ``matrix @ chi -> target``."""
        return cls(name, matrix, target, target)

    def residual(self, chi: Vector) -> Vector:
        """Return the signed distance of ``matrix @ chi`` to ``[lower, upper]``, shape (m,)."""
        value: Vector = self.matrix.dot(chi)
        if self.lower is self.upper:
            return value - self.lower
        return value - np.minimum(np.maximum(value, self.lower), self.upper)
