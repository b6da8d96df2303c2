"""A third backend: quadprog, the dual method of Goldfarb and Idnani."""

from __future__ import annotations

import numpy as np
import quadprog

from lexstack.hqp import Hierarchy, LevelQp, NullSpaceCascade, Signs
from lexstack.types import Vector

# It factors H, so a level that does not use all freedom needs a proximal term; the second one is
# for levels that are singular but for rounding. Where the feasible set has no interior, quadprog
# may find it empty, though z = 0 is in it: then its ends are opened a little.
_ATTEMPTS = ((1e-9, 0.0), (1e-6, 0.0), (1e-9, 1e-9), (1e-6, 1e-7))


class QuadprogBackend:
    """quadprog's one call: it keeps nothing between solves, and has no use for a guess."""

    name = "quadprog"

    def solve(self, qp: LevelQp, guess: Signs) -> Signs | str:
        """Solve with quadprog; its two-sided rows are one row for each end."""
        hessian, gradient = qp.quadratic()
        below, above = np.flatnonzero(qp.lower > -np.inf), np.flatnonzero(qp.upper < np.inf)
        rows = np.concatenate((qp.rows[below], -qp.rows[above]))
        ends = np.concatenate((qp.lower[below], -qp.upper[above]))
        word = ""
        for proximal, opening in _ATTEMPTS:
            definite = hessian + proximal * np.eye(gradient.size)
            try:
                multipliers = quadprog.solve_qp(definite, -gradient, rows.T, ends - opening)[4]
            except ValueError as error:
                word = str(error)
                continue
            sides: Signs = np.zeros(qp.lower.size, dtype=np.int8)
            sides[below[multipliers[: below.size] > 0.0]] = -1
            sides[above[multipliers[below.size :] > 0.0]] = 1
            return sides
        return word

    def predict_active_set(
        self, hierarchy: Hierarchy, lower: Vector, upper: Vector, guess: Signs
    ) -> Signs | None:
        """Foresee nothing: it does not solve programs whose weights span twelve decades."""
        return None


class QuadprogCascade(NullSpaceCascade):
    """The strict solver with quadprog."""

    def __init__(self, guesses: bool = True) -> None:
        """Without ``guesses`` every level goes through quadprog."""
        super().__init__(QuadprogBackend(), guesses)
