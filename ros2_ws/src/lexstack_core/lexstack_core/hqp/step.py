"""One link of the chain of least-squares problems that a guess of the active set leaves."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack_core.hqp.factor import Factor
from lexstack_core.hqp.rows import Indices
from lexstack_core.linear import Matrix, Vector


@dataclass(slots=True)
class Step:
    """One level of the chain, or several that are met together.

    Attributes:
        level: its place among the levels of the hierarchy; -1 where they are several.
        rows: the objective rows, all columns, shape (m, n).
        target: shape (m,).
        chosen: which rows of the hierarchy these are, shape (m,); None where none can be released.
        basis: the free directions above this level, shape (n, r); None for all.
        factor: of the rows in these directions.
    """

    level: int
    rows: Matrix
    target: Vector
    chosen: Indices | None
    basis: Matrix | None
    factor: Factor

    def move(self, chi: Vector) -> None:
        """Move chi, shape (n,), in place to the least-squares point of the rows."""
        if self.factor.rank > 0:
            move = self.factor.solve(self.target - self.rows.dot(chi))
            chi += move if self.basis is None else self.basis.dot(move)

    def balanced(self, gradients: Matrix) -> Matrix:
        """Return the multipliers of the rows, shape (k, m), for gradients of shape (k, n)."""
        return self.factor.solve_transposed(
            gradients if self.basis is None else gradients.dot(self.basis)
        )
