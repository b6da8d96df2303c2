"""The condensed QP of one SQP iteration, as a least-distance problem for DAQP.

    min g.d + d.H d / 2    subject to    lower <= A d <= upper

With H = R^T R and y = R d + R^-T g the cost is |y|^2 / 2 less a constant, so the problem is

    min |y|^2 / 2    subject to    lower + s <= A R^-1 y <= upper + s,    s = A R^-1 R^-T g

which is the form that DAQP uses inside: LAPACK factors H, and DAQP finds the active set among few
rows and never sees H. Then d = R^-1 (y - R^-T g).
"""

from __future__ import annotations

import daqp
import numpy as np

from lexstack.hqp.scipy_parts import blas, lapack
from lexstack.types import Matrix, Vector

_FAR = 1e30  # DAQP's infinity
_ITERATIONS = 2000
FINE, COARSE = 1e-9, 1e-6  # by how much a bound may be exceeded, for rows of length 1
_NO_LENGTH = 1e-13
_ACTIVE, _LOWER = 1, 2
_WORDS = {
    -1: "infeasible",
    -2: "cycling",
    -3: "unbounded",
    -4: "iteration limit",
    -5: "not convex",
    -6: "overdetermined working set",
}


class CondensedQp:
    """One factored H; gradients, rows and bounds come later."""

    def __init__(self, hessian: Matrix) -> None:
        """Factor H, shape (m, m), positive definite; it is overwritten."""
        # The transpose of a symmetric matrix is itself, and in the order that LAPACK wants. R is
        # the upper triangle; ``clean=0`` leaves numbers of H below it, which no call here reads.
        self._factor, self._info = lapack.dpotrf(hessian.T, clean=0, overwrite_a=1)

    @property
    def word(self) -> str:
        """``solved``, or why H could not be factored."""
        return "solved" if self._info == 0 else "the Hessian is not positive definite"

    def whiten(self, rows: Matrix) -> tuple[Matrix, Vector]:
        """Return the rows of A R^-1 with length 1, and 1 / their lengths, shapes (r, m), (r,).

        DAQP takes short rows for zero, and a bound on them for a contradiction. The factor is 0 for
        rows that no step can change.
        """
        if not len(rows):
            return rows, np.zeros(0)
        # R^T X = A^T gives X = R^-T A^T, the transpose of A R^-1: a triangular solve, no inverse.
        solved, _ = lapack.dtrtrs(self._factor, rows.T, trans=1)
        white = solved.T
        lengths = np.sqrt(np.einsum("ij,ij->i", white, white))
        factors = np.where(lengths > _NO_LENGTH, 1.0 / np.maximum(lengths, _NO_LENGTH), 0.0)
        return np.asarray(white * factors[:, None]), factors

    def center(self, gradient: Vector) -> Vector:
        """Return R^-T g, shape (m,), for which ``solve`` minimises the cost.

        For |R d + center|^2 / 2 = d.H d / 2 + g.d + constant.
        """
        return np.asarray(lapack.dtrtrs(self._factor, gradient, trans=1)[0])

    def center_at(self, point: Vector) -> Vector:
        """Return -R p, shape (m,), for which ``solve`` finds the d nearest to p in H's metric.

        For |R d + center|^2 = (d - p).H (d - p).
        """
        return np.asarray(-blas.dtrmv(self._factor, point))

    def solve(
        self,
        center: Vector,
        rows: Matrix,
        bounds: tuple[Vector, Vector],
        guess: Vector | None = None,
        tolerance: float = FINE,
    ) -> tuple[Vector, Vector, str]:
        """Return d, shape (m,), the multipliers, and ``solved`` or why it is not the optimum.

        Args:
            center: of ``center``.
            rows: of ``whiten``, shape (r, m).
            bounds: lower and upper ones of these rows, shape (r,); -inf and inf are legal.
            guess: multipliers of the first rows, whose signs are the first working set.
            tolerance: of these rows.
        """
        # Without rows y = 0 is the shortest.
        if not len(rows):
            return self._back(-center), np.zeros(0), self.word
        sense = np.zeros(len(rows), dtype=np.intc)
        if guess is not None:
            sense[: len(guess)][guess > 0.0] = _ACTIVE
            sense[: len(guess)][guess < 0.0] = _ACTIVE | _LOWER
        # A R^-1 y = A d + A R^-1 center: the bounds of A d, shifted by this, are those of y.
        lower, upper = bounds
        shift = rows @ center
        y, _, flag, info = daqp.solve(
            None,
            None,
            np.ascontiguousarray(rows),
            np.minimum(upper + shift, _FAR),
            np.maximum(lower + shift, -_FAR),
            sense,
            iter_limit=_ITERATIONS,
            primal_tol=tolerance,
        )
        word = "solved" if flag > 0 else _WORDS.get(flag, f"exit flag {flag}")
        return self._back(y - center), info["lam"], word

    def _back(self, whitened: Vector) -> Vector:
        """Return R^-1 y."""
        return np.asarray(lapack.dtrtrs(self._factor, whitened)[0])
