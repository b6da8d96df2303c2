"""The QP of a level within hard limits: only those limits enter that a solution would break.

All rows together would be some hundreds, of which a few tens hold. So the QP is solved with those
that held in the solve before, then those that its solution breaks are added, until none is broken:
the answer is that of the QP with all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.condensed_qp import COARSE, FINE, CondensedQp
from lexstack.mpc.hard_limits import HeldLimits
from lexstack.mpc.level_problem import Quadratic
from lexstack.mpc.linear_rows import LinearRows
from lexstack.types import Matrix, Vector

Places = NDArray[np.intp]
"""Rows and joints of hard limits, shape (2, r)."""

NOWHERE: Places = np.zeros((2, 0), dtype=np.intp)
_ROUNDS = 50


@dataclass(frozen=True, slots=True, eq=False)
class ActiveSet:
    """What held at a solution: a guess for the next one.

    Attributes:
        constraints: -1, 0 or 1 per row of the constraints of H(13): the side that holds, (g,).
        places: of the hard limits that hold.
        sides: -1 or 1 for each of them, shape (r,).
    """

    constraints: Vector
    places: Places
    sides: Vector


EMPTY = ActiveSet(np.zeros(0), NOWHERE, np.zeros(0))


class LevelQp(Protocol):
    """One QP of a level, and those near to it: this file's, or ``StructuredQp``."""

    @property
    def active_set(self) -> ActiveSet:
        """What held at the last solution."""

    @property
    def left(self) -> int:
        """How many QPs another solver had to solve."""

    def solve(self, lower: Vector, upper: Vector) -> tuple[Vector, str]:
        """Return d, shape (N n,), and the solver's word; bounds of the constraints, (g,)."""

    def nearest(self, point: Vector, lower: Vector, upper: Vector) -> tuple[Vector, str]:
        """Return the allowed d nearest to a point (N n,) in H's metric, and the solver's word."""

    def along(self, step: Vector) -> Vector:
        """Return E d for a step (N n,), shape (g,)."""


class LimitedQp:
    """One H and gradient, the constraints' rows, and the hard limits found so far.

    Attributes:
        places: of the hard limits that it has taken in.
        left: 0: it leaves no QP to another solver.
    """

    def __init__(
        self,
        qp: CondensedQp,
        gradient: Vector,
        constraints: Matrix,
        moving: Vector | None = None,
        first: ActiveSet = EMPTY,
    ) -> None:
        """Prepare the QP.

        Args:
            qp: with H factored.
            gradient: shape (N n,).
            constraints: their rows, shape (g, N n).
            moving: 1 for inputs that may change, else 0, shape (N n,); None: all may.
            first: what probably holds.
        """
        self._qp = qp
        self._center = qp.center(gradient)
        self._white, self._factors = qp.whiten(constraints)
        self._rows = constraints
        self._constraints = len(constraints)
        self._moving = moving
        self._hard: HeldLimits | None = None
        self._room = (np.zeros(0), np.zeros(0))
        same = first.constraints.size == len(constraints)
        self._multipliers: Vector = first.constraints if same else np.zeros(len(constraints))
        self._first = first
        self.places = NOWHERE
        self.left = 0

    def within(self, hard: HeldLimits, u: Matrix) -> None:
        """Keep the inputs u + d, both (N, n), within hard limits."""
        self._hard, self._u = hard, u
        values = hard.values(u)
        # A step of zero stays allowed, whatever rounding did to u.
        self._low = np.minimum(hard.lower - values, 0.0)
        self._high = np.maximum(hard.upper - values, 0.0)
        self._known = np.zeros(values.shape, dtype=bool)
        self._add(self._first.places)
        self._multipliers = np.concatenate((self._multipliers, self._first.sides))

    def nearest(self, point: Vector, lower: Vector, upper: Vector) -> tuple[Vector, str]:
        """Return the allowed d nearest to a point (N n,) in H's metric, and the solver's word."""
        self._center = self._qp.center_at(point)
        return self.solve(lower, upper)

    def solve(self, lower: Vector, upper: Vector) -> tuple[Vector, str]:
        """Return d, shape (N n,), and the solver's word; bounds of the constraints, (g,)."""
        for _ in range(_ROUNDS):
            direction, word = self._once(lower, upper)
            if self._hard is None or word != "solved":
                return direction, word
            broken = self._hard.violated(self._u + direction.reshape(self._u.shape))
            fresh = broken[:, ~self._known[broken[0], broken[1]]]
            if not fresh.size:
                return direction, word
            self._add(fresh)
        return direction, "hard limits: too many rounds"

    def along(self, step: Vector) -> Vector:
        """Return E d for a step (N n,), shape (g,)."""
        return self._rows @ step

    def _once(self, lower: Vector, upper: Vector) -> tuple[Vector, str]:
        """Solve with the rows so far.

        A guess can lead DAQP astray, and rows that depend on each other but for rounding can look
        like a contradiction: so again without a guess, and then with a wider tolerance.
        """
        if not len(self._white):
            direction, _, word = self._qp.solve(self._center, self._white, (lower, upper))
            return direction, word
        bounds = (
            self._scaled(np.concatenate((lower, self._room[0])), -np.inf),
            self._scaled(np.concatenate((upper, self._room[1])), np.inf),
        )
        for guess, tolerance in ((self._multipliers, FINE), (None, FINE), (None, COARSE)):
            direction, multipliers, word = self._qp.solve(
                self._center, self._white, bounds, guess, tolerance
            )
            if word == "solved":
                self._multipliers = multipliers
                break
        return direction, word

    @property
    def active_set(self) -> ActiveSet:
        """What held at the last solution."""
        signs = np.sign(self._multipliers)
        limits = signs[self._constraints :]
        held = np.flatnonzero(limits)
        return ActiveSet(signs[: self._constraints], self.places[:, held], limits[held])

    def _scaled(self, bounds: Vector, nothing: float) -> Vector:
        """Return bounds for rows of length 1; rows that no step can change are left out."""
        fixed = self._factors == 0.0
        scaled = bounds * np.where(fixed, 1.0, self._factors)
        return np.where(fixed, nothing, scaled)

    def _add(self, places: Places) -> None:
        """Take hard limits in."""
        if self._hard is None or not places.size:
            return
        row, joint = places
        self._known[row, joint] = True
        rows = self._hard.rows(places)
        white, factors = self._qp.whiten(rows if self._moving is None else rows * self._moving)
        self._white = np.concatenate((self._white, white))
        self._factors = np.concatenate((self._factors, factors))
        self._room = (
            np.concatenate((self._room[0], self._low[row, joint])),
            np.concatenate((self._room[1], self._high[row, joint])),
        )
        self.places = np.concatenate((self.places, places), axis=1)


def condensed_qp(
    quadratic: Quadratic,
    rows: LinearRows,
    hard: HeldLimits | None,
    u: Matrix,
    first: ActiveSet = EMPTY,
) -> tuple[LimitedQp | None, str]:
    """Return the QP of a level at inputs u (N, n), or None and why H could not be factored."""
    qp = CondensedQp(quadratic.hessian)
    if qp.word != "solved":
        return None, qp.word
    moving = None if rows.moving is None else np.tile(rows.moving, len(u))
    limited = LimitedQp(qp, quadratic.gradient, rows.matrix, moving, first)
    if hard is not None:
        limited.within(hard, u)
    return limited, qp.word
