"""What the compiled functions take: a problem, a guess of its active set, and their workspace."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lexstack.compiled import compiled
from lexstack.types import Matrix, Vector

Places = NDArray[np.int64]
Signs = NDArray[np.int8]
Flags = NDArray[np.bool_]

# As in hierarchy.py, which says why; compiled code takes them as constants.
RANK = 1e-8
INSIDE = 1e-11
ZERO = 1e-11
ROUNDING = 32.0 * 2.220446049250313e-16


class Rows(NamedTuple):
    """All levels: ``lower <= matrix @ chi <= upper``, equal ends are equality objectives.

    Attributes:
        matrix: shape (m, n).
        lower: shape (m,).
        upper: shape (m,).
        ends: one past the last row of each level.
    """

    matrix: Matrix
    lower: Vector
    upper: Vector
    ends: Places


class Box(NamedTuple):
    """Bounds of chi, shape (n,) each, and which joints cannot move."""

    low: Vector
    high: Vector
    fixed: Flags


class Guess(NamedTuple):
    """What is held: -1 at the lower, +1 at the upper end, 0 not.

    Attributes:
        held: of joints, shape (n,).
        sides: of inequality rows, shape (m,); 0 of equality rows.
    """

    held: Signs
    sides: Signs


class Factors(NamedTuple):
    """The factorisation A_F Q = L of the active rows of the deciding levels; see ``lq``.

    Attributes:
        work: L, and the vectors of the reflections to the right of its diagonal, shape (m, n).
        order: which row of the problem each row of ``work`` is, shape (m,).
        first: the first row of each level in ``work``, and one past the last of all.
        used: how many directions the levels above each one use, and all of them.
        norms: Frobenius norm of each level, 1 where it is zero.
        diag: the diagonal of L, by direction, shape (n,).
        heads: the first entry of each reflection's vector, by direction, shape (n,).
        makers: which row of ``work`` made each direction, shape (n,).
        basis: U of a level with dependent rows, L_k = U R, shape (m, n).
        triangle: R of such a level, shape (m, n).
        rest: A chi - b of the rows, in the order of ``work``, shape (m,).
        y: the move of chi by direction, shape (n,).
        free: which joints are free, shape (n,).
    """

    work: Matrix
    order: Places
    first: Places
    used: Places
    norms: Vector
    diag: Vector
    heads: Vector
    makers: Places
    basis: Matrix
    triangle: Matrix
    rest: Vector
    y: Vector
    free: Places


@compiled
def length_of(vector: Vector) -> float:
    """Return the length of a vector; a BLAS would add in an order of the processor's own."""
    square = 0.0
    for value in vector:
        square += value * value
    return math.sqrt(square)


@compiled
def workspace(rows: Rows, deciding: int) -> Factors:
    """Return the arrays for the factorisations of one solve, and the norms of the levels."""
    n = rows.matrix.shape[1]
    m = rows.ends[deciding - 1] if deciding else 0
    norms = np.ones(deciding)
    start = 0
    for k in range(deciding):
        square = 0.0
        for i in range(start, rows.ends[k]):
            for j in range(n):
                square += rows.matrix[i, j] * rows.matrix[i, j]
        if square > 0.0:
            norms[k] = math.sqrt(square)
        start = rows.ends[k]
    return Factors(
        np.empty((m, n)),
        np.empty(m, dtype=np.int64),
        np.empty(deciding + 1, dtype=np.int64),
        np.empty(deciding + 1, dtype=np.int64),
        norms,
        np.empty(n),
        np.empty(n),
        np.empty(n, dtype=np.int64),
        np.empty((m, n)),
        np.empty((m, n)),
        np.empty(m),
        np.empty(n),
        np.empty(n, dtype=np.int64),
    )
