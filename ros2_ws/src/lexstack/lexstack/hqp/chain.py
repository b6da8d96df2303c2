"""The chain of least-squares problems that a guess of the active set leaves.

Each problem is that of one level, in the null space of those above, with the joints of the working
set held at their bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.hqp.hierarchy import Hierarchy, Indices, LevelRows, Signs
from lexstack.hqp.rank_revealing_qr import Factor, factorise, factorise_full
from lexstack.types import Matrix, Vector


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


def lay_chain(
    hierarchy: Hierarchy, rows: Signs, basis: Matrix | None, chi: Vector, pressing: bool
) -> list[Step]:
    """Move chi to the lexicographic least-squares point of a guess; return the steps to it.

    Args:
        hierarchy: all levels.
        rows: which inequality rows are held, shape (M,).
        basis: the free joints, shape (n, r); None for all.
        chi: where the chain begins, the held joints at their bounds, shape (n,); moved in place.
        pressing: whether the steps behind the last freedom are of interest too.
    """
    levels, above = hierarchy.deciding, 0
    steps: list[Step] = []
    first = _merged(hierarchy, basis) if hierarchy.mergeable > 1 else None
    if first is not None:
        levels, above = levels[hierarchy.mergeable :], hierarchy.mergeable
        steps.append(first)
        basis = _move(first, chi, not levels)
    for k, level in enumerate(levels, start=1):
        if basis is not None and basis.shape[1] == 0 and not pressing:
            break
        last = k == len(levels)
        if not (level.exact or level.equal.any() or rows[level.rows].any()):
            continue  # no row of it asks for anything
        step = _step(level, above + k - 1, rows, basis, last)
        steps.append(step)
        basis = _move(step, chi, last)
    return steps


def _merged(hierarchy: Hierarchy, basis: Matrix | None) -> Step | None:
    """Return the first levels as one, if they can all be met: then their order does not matter."""
    count = hierarchy.mergeable
    levels = hierarchy.deciding[:count]
    end = levels[-1].rows.stop
    rows = hierarchy.matrix[:end]
    if end == 0 or (basis is not None and end > basis.shape[1]):
        return None
    tolerance = max([level.tolerance for level in levels])
    reduced = rows if basis is None else rows.dot(basis)
    factor = factorise_full(reduced, tolerance, count == len(hierarchy.deciding))
    if factor is None:
        return None
    return Step(-1, rows, hierarchy.lower[:end], None, basis, factor)


def _step(level: LevelRows, k: int, rows: Signs, basis: Matrix | None, last: bool) -> Step:
    """Return the step of level k, with its held rows, in the directions of ``basis``."""
    if level.exact:
        matrix, target, chosen = level.matrix, level.lower, None
    else:
        sides = rows[level.rows]
        local = np.flatnonzero(level.equal | (sides != 0))
        matrix = level.matrix[local]
        target = np.where(sides < 0, level.lower, level.upper)[local]
        chosen = local + level.rows.start
    reduced = matrix if basis is None else matrix.dot(basis)
    return Step(k, matrix, target, chosen, basis, factorise(reduced, level.tolerance, last))


def _move(step: Step, chi: Vector, last: bool) -> Matrix | None:
    """Move chi to the optimum of a step; return the directions that it leaves, None if last."""
    step.move(chi)
    if last:
        return None
    left: Matrix = step.factor.null if step.basis is None else step.basis.dot(step.factor.null)
    return left
