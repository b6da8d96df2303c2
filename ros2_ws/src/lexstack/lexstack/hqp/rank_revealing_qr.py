"""Rank-revealing factors of small dense matrices: least squares, its dual, and the null space.

LAPACK is called directly because it is what a solve of 20 variables spends its time on: a
pivoted QR takes 6 us here, numpy's SVD 38 us and numpy has no pivoted QR at all.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from lexstack.hqp.scipy_parts import lapack
from lexstack.types import Matrix, Vector

dgeqp3, dorgqr, dtrtrs = lapack.dgeqp3, lapack.dorgqr, lapack.dtrtrs

_WORK = 4096  # doubles of LAPACK workspace: enough for its blocked code at 60 columns


class Factor(Protocol):
    """A factored matrix M of shape (m, r) and numerical rank p.

    Attributes:
        rank: p, the number of directions with a pivot above the tolerance.
        null: orthonormal basis of the null space of M, shape (r, r - p).
    """

    rank: int
    null: Matrix

    def solve(self, target: Vector) -> Vector:
        """Return the shortest z, shape (r,), that minimises ``||M z - target||``."""
        ...

    def solve_transposed(self, gradients: Matrix) -> Matrix:
        """Return mu, shape (k, m), with ``mu M = gradients``, shape (k, r), in M's row space."""
        ...


def factorise(matrix: Matrix, tolerance: float, last: bool = False) -> Factor:
    """Factor ``matrix``, shape (m, r); pivots of at most ``tolerance`` count as zero.

    The pivots are the diagonal of R in a QR with column pivoting (of the matrix or its transpose).
    Each step takes the column with the largest remainder next, so they fall in size, and the
    remainders of all columns that are left are at most as long as the next pivot. The rank p is the
    number of pivots above the tolerance; what is dropped with the others is, in each column of the
    matrix that was factored, at most ``tolerance`` long.

    The tolerance is absolute because a matrix that was reduced to a null space may hold rounding
    errors only, and relative to its own norm these would have full rank. The caller knows the scale
    of the task before the reduction: levels take 1e-8 of that (``RANK_TOLERANCE``).

    Args:
        matrix: left as it is.
        tolerance: absolute.
        last: that nobody will ask for the null space, which may be empty then.
    """
    rows, columns = matrix.shape
    if rows == 0 or columns == 0:
        return _Zero(rows, columns)
    # More rows than columns: a QR of the matrix itself solves least squares if all columns are
    # independent. The last pivot is the smallest, so it alone decides. Otherwise the directions
    # that are missing have to be found, which needs the QR of the transpose.
    if rows > columns:
        tall = _Tall(matrix)
        if abs(tall.triangle[-1, -1]) > tolerance:  # pivots fall in size
            return tall
    return _wide(matrix, tolerance, last)


def factorise_full(matrix: Matrix, tolerance: float, last: bool = False) -> Factor | None:
    """Factor a matrix of full row rank, shape (m, r) with 0 < m <= r; return None for any other."""
    # Levels that are met together need every row; a missing rank sends the caller to factor them
    # one by one. So the last pivot alone is looked at, and Q is not formed in vain.
    rows = len(matrix)
    packed, pivots, tau, _, _ = dgeqp3(matrix.T, lwork=_WORK)
    if abs(packed[rows - 1, rows - 1]) <= tolerance:
        return None
    return _Wide(packed[:rows], pivots - 1, _orthogonal(packed, tau, last))


def _wide(matrix: Matrix, tolerance: float, last: bool) -> Factor:
    """Factor by QR of the transpose, ``M.T P = Q R``; factor once more where rank is missing.

    The first p columns of Q span the row space of M, its other columns the null space.
    """
    rows, columns = matrix.shape
    packed, pivots, tau, _, _ = dgeqp3(matrix.T, lwork=_WORK)
    size = min(rows, columns)
    # Counting is for the rare case: pivots fall in size, so if the last one is large, all are.
    rank = size
    if abs(packed[size - 1, size - 1]) <= tolerance:
        rank = int(np.count_nonzero(np.abs(packed.diagonal()) > tolerance))
    if rank == 0:
        return _Zero(rows, columns)
    order = pivots - 1
    basis = _orthogonal(packed[:, :size], tau, last)
    if rank == rows:
        return _Wide(packed[:rows], order, basis)
    # Dependent rows may have targets that contradict each other, so p of the rows cannot stand for
    # all. All m are kept, as L = R[:p].T, and least squares decides among them.
    return _Deficient(np.triu(packed[:rank]).T, order, basis)


def _orthogonal(packed: Matrix, tau: Vector, thin: bool) -> Matrix:
    """Return Q of a QR of shape (r, m), m <= r: its first m columns if ``thin``, else all r."""
    columns, size = packed.shape
    if thin or size == columns:
        first: Matrix = dorgqr(packed, tau, lwork=_WORK)[0]
        return first
    full = np.empty((columns, columns), order="F")  # dorgqr fills the columns after the first ones
    full[:, :size] = packed
    basis: Matrix = dorgqr(full, tau, lwork=_WORK, overwrite_a=1)[0]
    return basis


class _Zero:
    """A matrix without rows, without columns, or of rank zero."""

    rank = 0

    def __init__(self, rows: int, columns: int) -> None:
        self._rows = rows
        self._columns = columns
        self.null: Matrix = np.eye(columns)

    def solve(self, target: Vector) -> Vector:
        return np.zeros(self._columns)

    def solve_transposed(self, gradients: Matrix) -> Matrix:
        return np.zeros((len(gradients), self._rows))


class _Wide:
    """Full row rank: ``M.T P = Q [R; 0]``, so with Q1 the first m columns ``P.T M = R.T Q1.T``.

    Every target is met: ``R.T y = P.T target``, and z = Q1 y is the shortest such z, as it has no
    part in the null space.
    """

    def __init__(self, triangle: Matrix, order: Vector, basis: Matrix) -> None:
        self.rank = order.size
        self.null: Matrix = basis[:, self.rank :]
        self._triangle = triangle
        self._order = order
        self._range = basis[:, : self.rank]

    def solve(self, target: Vector) -> Vector:
        z: Vector = self._range.dot(dtrtrs(self._triangle, target[self._order], trans=1)[0])
        return z

    def solve_transposed(self, gradients: Matrix) -> Matrix:
        mu = np.empty((len(gradients), self.rank))
        mu[:, self._order] = dtrtrs(self._triangle, gradients.dot(self._range).T)[0].T
        return mu


class _Tall:
    """Full column rank, at least as many rows as columns: ``M P = Q R``; callers check the pivots.

    Least squares: ``R P.T z = Q.T target``. There is no null space.
    """

    def __init__(self, matrix: Matrix) -> None:
        self.rank = matrix.shape[1]
        packed, pivots, tau, _, _ = dgeqp3(matrix, lwork=_WORK)
        self.null: Matrix = np.empty((self.rank, 0))
        self.triangle: Matrix = packed[: self.rank]
        self._order = pivots - 1
        self._range: Matrix = dorgqr(packed, tau, lwork=_WORK)[0]

    def solve(self, target: Vector) -> Vector:
        z = np.empty(self.rank)
        z[self._order] = dtrtrs(self.triangle, target.dot(self._range))[0]
        return z

    def solve_transposed(self, gradients: Matrix) -> Matrix:
        inner = dtrtrs(self.triangle, gradients[:, self._order].T, trans=1)[0]
        mu: Matrix = inner.T.dot(self._range.T)
        return mu


class _Deficient:
    """Rank p < m: ``M = P L Q1.T`` with L, shape (m, p), of full column rank.

    Two steps: y minimises ``||L y - P.T target||``, and z = Q1 y is the shortest z with that y.
    """

    def __init__(self, lower: Matrix, order: Vector, basis: Matrix) -> None:
        self.rank = lower.shape[1]
        self.null: Matrix = basis[:, self.rank :]
        self._inner = _Tall(lower)
        self._order = order
        self._range = basis[:, : self.rank]

    def solve(self, target: Vector) -> Vector:
        z: Vector = self._range.dot(self._inner.solve(target[self._order]))
        return z

    def solve_transposed(self, gradients: Matrix) -> Matrix:
        mu = np.empty((len(gradients), self._order.size))
        mu[:, self._order] = self._inner.solve_transposed(gradients.dot(self._range))
        return mu
