"""Newton's step along valleys: directions of which the model of ``lift`` has too much curvature.

Rows can add curvature to a level and not take it away, so the model of a damped level

    M = J^T J + R^T R

is above the true second derivative T = J^T D J + B(e) wherever B bends both ways. Along an
eigenvector v of T with a small eigenvalue t the error then shrinks with a small part of the gain,
and the robots creep. There the step of Newton's method takes the place of the model's:

    x = M^-1 g        x' = x + sum_v f_v v (v^T G^-1 g / |t_v| - v^T x)

with g what the level asks for, in which its lost part is scaled down (by G, on the directions that
see it), and f_v = 1 where |t_v| v^T M^-1 G v, the rate of the model as a share of the gain, is
small. The rows become [J; R] chi -> K [J; R] x', which is x' where no bound is in the way.

D holds what the logarithm of a rotation bends: 1 along it, (a/2) / tan(a/2) across it at the
angle a.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lexstack.hqp.group_level import GroupLevel
from lexstack.hqp.scipy_parts import lapack
from lexstack.types import Matrix, Vector

_RANK = 1e-8  # of the largest singular value: below it a level does not see a direction
_FLAT = 1e-4  # m, times |e|: less curvature counts as that much
_FASTER = 4.0  # than Newton's step the model's may be
_LONGEST = 1.0  # rad or m: a step stays below, as far as a second derivative can be trusted


@dataclass(frozen=True, slots=True)
class Model:
    """The second derivative that a level has with the rows that were added, in f directions.

    Attributes:
        rows: R, shape (k, f).
        squares: eigenvalues of M on the directions that it sees, shape (r,).
        seen: these directions, orthonormal, shape (f, r).
        null: the others, shape (f, f - r).
    """

    rows: Matrix
    squares: Vector
    seen: Matrix
    null: Matrix

    @classmethod
    def of(cls, matrix: Matrix, rows: Matrix, size: float) -> Model:
        """Return it, with rows for what it sees too little of.

        However small a singular value is, it takes a direction from the levels below, and lets
        rounding ask for any velocity along it.

        Args:
            matrix: J, shape (m, f).
            rows: R, shape (k, f).
            size: |e|, as the level asks for it.
        """
        _, values, vt = singular(np.concatenate((matrix, rows)))
        count = int(np.count_nonzero(values > _RANK * values[0]))
        squares, least = np.square(values[:count]), _FLAT * size
        weak = squares < least
        if weak.any():
            more = np.sqrt(least - squares[weak])[:, None] * vt[:count][weak]
            rows, squares = np.concatenate((rows, more)), np.maximum(squares, least)
        return cls(rows, squares, vt[:count].T, vt[count:].T)

    def step(self, true: Matrix, asked: tuple[Vector, Vector], size: float) -> Vector:
        """Return x' - x, shape (f,).

        Args:
            true: T, shape (f, f).
            asked: g, and G^-1 g.
            size: |e|, before it was scaled down.
        """
        values, vectors = symmetric(self.seen.T.dot(true).dot(self.seen))
        curvature = np.maximum(np.abs(values), _FLAT * size)
        inverse = vectors / self.squares[:, None]
        directions = self.seen.dot(vectors)
        step = asked[1].dot(directions) / curvature
        step /= np.sqrt(1.0 + np.square(step / _LONGEST))
        model = asked[0].dot(self.seen).dot(inverse)
        least, most = np.minimum(step, _FASTER * step), np.maximum(step, _FASTER * step)
        bounded = np.minimum(np.maximum(model, least), most)
        result: Vector = directions.dot(bounded - model)
        return result


def logarithm(level: GroupLevel, error: Vector, matrix: Matrix) -> Matrix:
    """Return J^T (D - 1) J of a level's orientations, shape (f, f).

    Args:
        level: whose tasks say which rows are orientations.
        error: not saturated, shape (m,).
        matrix: J, shape (m, f).
    """
    total = np.zeros((matrix.shape[1], matrix.shape[1]))
    for task, start in zip(level.tasks, level.starts, strict=True):
        if task.curve is None or len(task.curve.limits) < 2 or task.curve.sizes:
            continue
        turn, rows = error[start + 3 : start + 6], matrix[start + 3 : start + 6]
        angle = math.sqrt(float(turn.dot(turn)))
        half = 0.5 * min(angle / task.curve.scale, math.pi)
        if half < 1e-4:
            continue
        along = turn.dot(rows) / angle
        total += (half / math.tan(half) - 1.0) * (rows.T.dot(rows) - along[:, None] * along)
    return total


def singular(matrix: Matrix) -> tuple[Matrix, Vector, Matrix]:
    """Return u, s and v^T of a matrix, as numpy does in twice the time.

    Raises:
        numpy.linalg.LinAlgError: there are none, as of what is no number.
    """
    if not matrix.size:
        return np.linalg.svd(matrix)
    u, values, vt, failed = lapack.dgesdd(matrix)
    if failed or not math.isfinite(float(values.sum())):
        raise np.linalg.LinAlgError("a level is not finite, or has no singular values")
    return u, values, vt


def symmetric(matrix: Matrix) -> tuple[Vector, Matrix]:
    """Return eigenvalues and eigenvectors of a symmetric matrix.

    Raises:
        numpy.linalg.LinAlgError: there are none.
    """
    values, vectors, failed = lapack.dsyevd(matrix)
    if failed:
        raise np.linalg.LinAlgError("the second derivative of a level has no eigenvalues")
    return values, vectors
