"""The quadratic program of one level in reduced coordinates, and what its solvers return."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lexstack.hqp.hierarchy import FEASIBILITY, RANK_TOLERANCE, Hierarchy, Mask, Signs, noise
from lexstack.types import Matrix, Vector

FAR = 1e30  # a bound that no solver reaches
PROXIMAL = 1e-9


@dataclass(slots=True)
class LevelQp:
    """``min ||objective x - target||^2`` within ``lower <= rows x <= upper``.

    x is z, the move in the free directions, shape (r,), and then w, one slack for each inequality
    row of the level, in units of ``norm``: the row is ``lower <= A z - norm w <= upper`` and w an
    objective, so that what it cannot reach is minimised like the residual of an equality row.

    Attributes:
        objective: shape (m, r + s).
        target: shape (m,).
        rows: hard rows first, then the level's own inequality rows, shape (h + s, r + s).
        lower: shape (h + s,).
        upper: shape (h + s,).
        start: a point inside, with z = 0, shape (r + s,).
        slacks: s.
        simple: how many of the first rows are those of the unit matrix.
        norm: Frobenius norm of the level's rows before they were reduced, positive.
        tolerance: pivots of the objective below this count as zero.
        proximal: what H may get on its diagonal, of a trace of about 1, to become definite.
    """

    objective: Matrix
    target: Vector
    rows: Matrix
    lower: Vector
    upper: Vector
    start: Vector
    slacks: int
    simple: int
    norm: float
    tolerance: float
    proximal: float

    def quadratic(self) -> tuple[Matrix, Vector]:
        """Return H and f of ``min x.T H x / 2 + f.T x``.

        Scaled by the task, not by what the levels above leave of it: a level that is almost used
        up would have an enormous gradient, on which solvers stall.
        """
        scale = -1.0 / (self.norm * self.norm)
        hessian = self.objective.T.dot(self.objective)
        hessian *= -scale
        return hessian, scale * self.target.dot(self.objective)

    def contains(self, x: Vector) -> bool:
        """Whether x is inside all rows, up to rounding."""
        value = self.rows.dot(x)
        excess = np.maximum(value - self.upper, self.lower - value)
        inside = max(FEASIBILITY, noise(float(np.abs(x).max(initial=0.0))))
        return bool(excess.max(initial=0.0) <= inside)

    def limits(self) -> tuple[Vector, Vector]:
        """Return the bounds of the rows, finite."""
        return np.maximum(self.lower, -FAR), np.minimum(self.upper, FAR)


def level_qp(
    reduced: Matrix,
    equal: Mask,
    ends: tuple[Vector, Vector],
    hard: tuple[Matrix, Vector, Vector],
    norm: float,
    *,
    proximal: float = PROXIMAL,
    simple: int = 0,
) -> LevelQp:
    """Return the program of a level.

    Args:
        reduced: the level's rows in z, shape (m, r).
        equal: which of them are equality objectives, shape (m,).
        ends: lower and upper end of each row, from where chi is, shapes (m,).
        hard: rows in z with lower <= 0 <= upper: shapes (h, r), (h,), (h,).
        norm: of the level's rows before they were reduced.
        proximal: what H may get on its diagonal.
        simple: how many of the first hard rows are rows of the unit matrix.
    """
    rows, lower, upper = hard
    tolerance = RANK_TOLERANCE * norm
    if equal.all():
        start = np.zeros(reduced.shape[1])
        return LevelQp(
            reduced, ends[0], rows, lower, upper, start, 0, simple, norm, tolerance, proximal
        )
    exact, soft = reduced[equal], reduced[~equal]
    low, high = ends[0][~equal], ends[1][~equal]
    s, r = soft.shape
    objective = np.zeros((exact.shape[0] + s, r + s))
    objective[: exact.shape[0], :r] = exact
    objective[exact.shape[0] :, r:] = norm * np.eye(s)
    stacked = np.zeros((lower.size + s, r + s))
    stacked[: lower.size, :r] = rows
    stacked[lower.size :, :r] = soft
    stacked[lower.size :, r:] = -norm * np.eye(s)
    return LevelQp(
        objective=objective,
        target=np.concatenate((ends[0][equal], np.zeros(s))),
        rows=stacked,
        lower=np.concatenate((lower, low)),
        upper=np.concatenate((upper, high)),
        start=np.concatenate((np.zeros(r), -np.minimum(np.maximum(0.0, low), high) / norm)),
        slacks=s,
        simple=simple,
        norm=norm,
        tolerance=tolerance,
        proximal=proximal,
    )


class QpBackend(Protocol):
    """Solves the quadratic program of a level; one file per library."""

    name: str

    def solve(self, qp: LevelQp, guess: Signs) -> Signs | str:
        """Return which rows hold at the optimum, shape (h + s,), or its word for why not.

        Only the active set is asked for: the optimum that belongs to it is computed exactly, and
        does not depend on the last bits of a library.

        Args:
            qp: the level.
            guess: which of the first rows probably hold, shape (at most h,).
        """
        ...

    def predict_active_set(
        self, hierarchy: Hierarchy, lower: Vector, upper: Vector, guess: Signs
    ) -> Signs | None:
        """Return what probably holds at the optimum of all levels, or None if it has no idea.

        Args:
            hierarchy: all levels.
            lower: bounds of chi, shape (n,).
            upper: shape (n,).
            guess: of the bounds that hold, shape (n,).

        Returns:
            Sides of the bounds and of all inequality rows, in this order.
        """
        ...
