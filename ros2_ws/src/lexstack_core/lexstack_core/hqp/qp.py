"""The quadratic program of one level in reduced coordinates, and what its solvers return."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lexstack_core.hqp.rows import Signs
from lexstack_core.linear import Matrix, Vector

FAR = 1e30  # a bound that no solver reaches


@dataclass(frozen=True, slots=True)
class LevelQp:
    """``min ||objective z - target||^2 + ||w||^2`` with hard rows and rows relaxed by w.

    ``hard_lower <= hard z <= hard_upper`` and ``soft_lower <= soft z - w <= soft_upper``.
    z = 0 satisfies the hard rows.

    Attributes:
        objective: shape (m, r).
        target: shape (m,).
        hard: bounds of chi and inequality rows of the levels above, shape (h, r).
        hard_lower: shape (h,), at most 0.
        hard_upper: shape (h,), at least 0.
        soft: inequality rows of this level, shape (s, r).
        soft_lower: shape (s,).
        soft_upper: shape (s,).
        norm: Frobenius norm of the level's rows before they were reduced, positive.
        tolerance: pivots of the objective below this count as zero.
    """

    objective: Matrix
    target: Vector
    hard: Matrix
    hard_lower: Vector
    hard_upper: Vector
    soft: Matrix
    soft_lower: Vector
    soft_upper: Vector
    norm: float
    tolerance: float

    def assemble(self) -> tuple[Matrix, Vector, Matrix, Vector, Vector]:
        """Return H, f, C, lower, upper of the same problem in (z, w), with finite bounds."""
        r, s = self.objective.shape[1], self.soft_lower.size
        hessian = self.objective.T.dot(self.objective)
        gradient = -self.target.dot(self.objective)
        # By the scale of the task, not of what the levels above leave of it: a level that is
        # almost used up would have an enormous gradient, on which solvers stall.
        scale = 1.0 / (self.norm * self.norm)
        hessian *= scale
        gradient *= scale
        rows, lower, upper = self.hard, self.hard_lower, self.hard_upper
        if s:
            full = scale * np.eye(r + s)
            full[:r, :r] = hessian
            hessian, gradient = full, np.concatenate((gradient, np.zeros(s)))
            rows = np.zeros((self.hard_lower.size + s, r + s))
            rows[:-s, :r] = self.hard
            rows[-s:, :r] = self.soft
            rows[-s:, r:] = -np.eye(s)
            lower = np.concatenate((lower, self.soft_lower))
            upper = np.concatenate((upper, self.soft_upper))
        return hessian, gradient, rows, np.maximum(lower, -FAR), np.minimum(upper, FAR)


@dataclass(frozen=True, slots=True)
class QpAnswer:
    """What a backend found; every vector may be inaccurate by the backend's tolerance.

    Attributes:
        z: shape (r,).
        multipliers: of the hard rows, positive at the upper bound, shape (h,).
        reason: empty when solved, else the backend's word for why not.
    """

    z: Vector
    multipliers: Vector
    reason: str


class QpBackend(Protocol):
    """Solves the quadratic program of a level; one file per library."""

    name: str

    def solve(self, qp: LevelQp, guess: Signs) -> QpAnswer:
        """Solve; ``guess`` says which hard rows probably hold, shape (h,)."""
        ...
