"""A level seen from the free directions: its rows, and the constraints it inherits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.hqp.hierarchy import Indices, LevelRows, Mask
from lexstack.hqp.level_qp import LevelQp, level_qp
from lexstack.types import Matrix, Vector

_NEGLIGIBLE = 1e-9  # a joint whose row of the basis is shorter than this cannot leave its bounds


@dataclass(frozen=True, slots=True)
class InheritedConstraints:
    """Rows that no level below may leave: the bounds of chi, satisfied inequality rows.

    Attributes:
        matrix: shape (h, n).
        lower: shape (h,).
        upper: shape (h,).
        tolerance: reduced rows shorter than this cannot be left.
    """

    matrix: Matrix
    lower: Vector
    upper: Vector
    tolerance: float

    @classmethod
    def of_bounds(cls, lower: Vector, upper: Vector) -> InheritedConstraints:
        """Return the bounds of chi, shape (n,)."""
        return cls(np.eye(lower.size), lower, upper, _NEGLIGIBLE)

    @classmethod
    def of_satisfied(cls, level: LevelRows, broken: Mask) -> InheritedConstraints:
        """Return a level's satisfied inequality rows; ``broken`` says which are not, shape (s,).

        The broken ones are equations for the levels below, and part of their null space already.
        """
        rows = np.flatnonzero(~level.equal)[~broken]
        return cls(level.matrix[rows], level.lower[rows], level.upper[rows], level.tolerance)


def reduce_level(
    level: LevelRows, chi: Vector, basis: Matrix, inherited: list[InheritedConstraints]
) -> tuple[LevelQp, Indices]:
    """Return a level in z, where chi becomes chi + N z, and the joints of its first rows.

    Args:
        level: of n columns.
        chi: inside all of them but for rounding, shape (n,).
        basis: N, orthonormal, shape (n, r).
        inherited: the bounds of chi first.
    """
    hard, below, above = [], [], []
    joints = np.empty(0, dtype=np.intp)
    for k, constraints in enumerate(inherited):
        rows = basis if k == 0 else constraints.matrix.dot(basis)
        # Rows that the levels above have used up hold rounding errors, on which solvers fail.
        felt = np.flatnonzero(
            np.einsum("ij,ij->i", rows, rows) > constraints.tolerance * constraints.tolerance
        )
        value = constraints.matrix.dot(chi)
        hard.append(rows[felt])
        below.append((constraints.lower - value)[felt])
        above.append((constraints.upper - value)[felt])
        joints = felt if k == 0 else joints
    reduced = level.matrix.dot(basis)
    reduced[np.einsum("ij,ij->i", reduced, reduced) <= level.tolerance * level.tolerance] = 0.0
    value = level.matrix.dot(chi)
    qp = level_qp(
        reduced,
        level.equal,
        (level.lower - value, level.upper - value),
        (
            np.concatenate(hard),
            np.minimum(np.concatenate(below), 0.0),
            np.maximum(np.concatenate(above), 0.0),
        ),
        level.norm,
    )
    return qp, joints
