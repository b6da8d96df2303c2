"""From the rows that hold to the exact optimum of a level, and the freedom it leaves.

A backend's answer is as good as its tolerances and its regularisation. The rows that it found to
hold, taken as equations, leave a least-squares problem without either. If its solution is not the
optimum, near singularities for instance, a primal active-set method goes on: to the next row in
the way, or away from the row that pulls most. Mostly the first look ends it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.hqp.hierarchy import FEASIBILITY, MULTIPLIER, Signs, noise
from lexstack.hqp.level_qp import LevelQp
from lexstack.hqp.rank_revealing_qr import Factor, factorise
from lexstack.types import Matrix, Vector

_STEPS = 100  # for up to 100 rows, more in proportion
_ROUNDING = 1e-13
_TOUCH = 1e-9  # nearer than this to its bound, a row holds
_ROW_TOLERANCE = 1e-9  # pivots among the rows, which have norms of about 1


@dataclass(frozen=True, slots=True)
class Point:
    """The optimum of a level.

    Attributes:
        z: shape (r,).
        null: orthonormal basis of what the levels below may do, shape (r, r').
        broken: which of the level's inequality rows are not satisfied, shape (s,).
    """

    z: Vector
    null: Matrix
    broken: NDArray[np.bool_]


@dataclass(slots=True)
class _Corner:
    """The least-squares point with the working rows as equations.

    Attributes:
        x: shape (r + s,).
        pressed: multipliers of all rows, positive at the upper bound, shape (h + s,).
        working: factor of the working rows.
        objective: factor of the objective in the directions that these leave.
    """

    x: Vector
    pressed: Vector
    working: Factor
    objective: Factor


def refine(qp: LevelQp, sides: Signs) -> Point | str:
    """Return the exact optimum of a level, or why there is none.

    Args:
        qp: the level.
        sides: where the rows probably hold, shape (h + s,).
    """
    x = qp.start
    sides = sides.copy()
    for _ in range(_STEPS * max(1, sides.size // 50)):
        corner = _corner(qp, x, sides)
        if not math.isfinite(corner.x.dot(corner.x)):
            return "not finite"
        part, row = _reach(qp, x, corner.x, sides)
        if row < 0:
            pulled = sides * corner.pressed
            worst = int(np.argmin(pulled)) if pulled.size else -1
            if worst < 0 or pulled[worst] >= -_zero(qp, corner):
                return _point(qp, corner, sides)
            x = corner.x
            sides[worst] = 0
        else:
            x = x + part * (corner.x - x)
            # What was guessed to hold may not yet, and would contradict the row in the way.
            value = qp.rows.dot(x)
            sides[np.where(sides > 0, qp.upper - value, value - qp.lower) > _TOUCH] = 0
            sides[row] = 1 if qp.rows[row].dot(corner.x) > qp.upper[row] else -1
    return "no optimum near its active set"


def _corner(qp: LevelQp, x: Vector, sides: Signs) -> _Corner:
    """Return the optimum with the working rows as equations that is nearest to x."""
    held = np.flatnonzero(sides)
    bound = np.where(sides > 0, qp.upper, qp.lower)[held]
    rows = qp.rows[held]
    working = factorise(rows, _ROW_TOLERANCE)
    on_working = x + working.solve(bound - rows.dot(x))
    factor = factorise(qp.objective.dot(working.null), qp.tolerance)
    move = factor.solve(qp.target - qp.objective.dot(on_working))
    corner: Vector = on_working + working.null.dot(move)
    residual = qp.objective.dot(corner) - qp.target
    pressed = np.zeros(sides.size)
    pressed[held] = working.solve_transposed(-residual.dot(qp.objective)[None])[0]
    return _Corner(corner, pressed, working, factor)


def _zero(qp: LevelQp, corner: _Corner) -> float:
    """Return below which size a multiplier is rounding of the numbers that it was made of."""
    length = math.sqrt(corner.x.dot(corner.x))
    goal = math.sqrt(qp.target.dot(qp.target))
    forces = math.sqrt(corner.pressed.dot(corner.pressed))
    return max(MULTIPLIER, noise(qp.norm * (qp.norm * length + goal) + forces))


def _inside(x: Vector) -> float:
    """Return how far outside a row x may be and still count as inside."""
    return max(FEASIBILITY, noise(float(np.abs(x).max(initial=0.0))))


def _reach(qp: LevelQp, x: Vector, corner: Vector, sides: Signs) -> tuple[float, int]:
    """Return how far from x to the corner all rows hold, and the row in the way or -1."""
    value = qp.rows.dot(corner)
    excess = np.maximum(value - qp.upper, qp.lower - value)
    # Next to a singularity the corner is far away, and held rows hold with its rounding only.
    excess[sides != 0] -= _ROUNDING * float(np.abs(corner).max(initial=0.0))
    inside = _inside(corner)
    if excess.max(initial=0.0) <= inside:
        return 1.0, -1
    outside = np.flatnonzero(excess > inside)
    way = np.abs(value[outside] - qp.rows[outside].dot(x))
    part = 1.0 - excess[outside] / np.maximum(way, excess[outside])
    first = int(np.argmin(part))
    return float(part[first]), int(outside[first])


def _point(qp: LevelQp, corner: _Corner, sides: Signs) -> Point:
    """Return the optimum and the directions that change neither it nor a row that presses on it.

    A row with a multiplier holds for every optimum of the level: kept as an inequality, it would
    leave the levels below a feasible set without interior, where solvers stall.
    """
    felt = np.abs(corner.pressed) > _zero(qp, corner)
    if qp.slacks == 0:
        if np.count_nonzero(felt) == np.count_nonzero(sides):
            null = corner.working.null.dot(corner.objective.null)
        else:
            null = _null(qp.rows[felt], qp.objective, qp.tolerance)
        return Point(corner.x, null, np.zeros(0, dtype=np.bool_))
    s = qp.slacks
    z, w = corner.x[:-s], corner.x[-s:]
    broken = np.abs(w) * qp.norm > _inside(corner.x)
    rows = qp.rows[:-s, :-s][felt[:-s]]
    objective = np.concatenate((qp.objective[:-s, :-s], qp.rows[-s:, :-s][broken]))
    return Point(z, _null(rows, objective, qp.tolerance), broken)


def _null(rows: Matrix, objective: Matrix, tolerance: float) -> Matrix:
    """Return the directions that leave both alone."""
    working = factorise(rows, _ROW_TOLERANCE)
    null: Matrix = working.null.dot(factorise(objective.dot(working.null), tolerance).null)
    return null
