"""From what a backend found to the exact optimum of a level, and the freedom it leaves.

A backend's z is as good as its tolerances and its regularisation. The rows that it found to hold
give an equality-constrained least-squares problem without either; where its solution satisfies the
optimality conditions it is the exact one. It is found as a correction of z: of all optima of a
level that does not use all freedom, the one next to z stays inside the rows that z is inside of.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack_core.hqp.factor import factorise
from lexstack_core.hqp.qp import LevelQp, QpAnswer
from lexstack_core.hqp.rows import FEASIBILITY, MULTIPLIER, Signs
from lexstack_core.linear import Matrix, Vector

_ROUNDS = 5
_ROW_TOLERANCE = 1e-9  # pivots among hard rows, which have norms of at most about 1


@dataclass(frozen=True, slots=True)
class Point:
    """The optimum of a level.

    Attributes:
        z: shape (r,).
        null: orthonormal basis of what the levels below may do, shape (r, r').
        broken: which soft rows are not satisfied: -1 below, +1 above, shape (s,).
    """

    z: Vector
    null: Matrix
    broken: Signs


@dataclass(slots=True)
class _Working:
    """The rows taken to hold: hard ones at a bound, soft ones outside theirs; shapes (h,), (s,)."""

    hard: Signs
    soft: Signs


def refine(qp: LevelQp, answer: QpAnswer) -> Point:
    """Return the exact optimum near a backend's, or the backend's own if none is found."""
    z, multipliers = answer.z, answer.multipliers
    soft = _sides_outside(qp.soft.dot(z), qp.soft_lower, qp.soft_upper, FEASIBILITY)
    working = _Working(np.sign(multipliers).astype(np.int8), soft)
    for _ in range(_ROUNDS):
        exact, pressed = _correct(qp, z, working)
        if not _exchange(qp, exact, pressed, working):
            z, multipliers = exact, pressed
            break
    else:
        working = _Working(np.sign(multipliers).astype(np.int8), soft)
    felt = np.abs(multipliers) > MULTIPLIER
    return Point(z, _freedom(qp, felt, working.soft), working.soft)


def _correct(qp: LevelQp, z: Vector, working: _Working) -> tuple[Vector, Vector]:
    """Return the least-squares point with the working rows as equations, and its multipliers."""
    held = np.flatnonzero(working.hard)
    bound = np.where(working.hard > 0, qp.hard_upper, qp.hard_lower)[held]
    rows = qp.hard[held]
    walls = factorise(rows, _ROW_TOLERANCE)
    on_walls = z + walls.solve(bound - rows.dot(z))
    objective, target = _objective(qp, working.soft)
    factor = factorise(objective.dot(walls.null), qp.tolerance)
    exact: Vector = on_walls + walls.null.dot(factor.solve(target - objective.dot(on_walls)))
    residual = objective.dot(exact) - target
    pressed = np.zeros(working.hard.size)
    pressed[held] = walls.solve_transposed(-residual.dot(objective))
    return exact, pressed


def _exchange(qp: LevelQp, z: Vector, pressed: Vector, working: _Working) -> bool:
    """Correct the working rows by what z violates or pulls; return whether there was anything."""
    outside = _sides_outside(qp.hard.dot(z), qp.hard_lower, qp.hard_upper, FEASIBILITY)
    pulled = working.hard * pressed < -MULTIPLIER
    added = (working.hard == 0) & (outside != 0)
    working.hard[pulled] = 0
    working.hard[added] = outside[added]
    value = qp.soft.dot(z)
    wall = np.where(working.soft > 0, qp.soft_upper, qp.soft_lower)
    soft_pulled = working.soft * (value - np.where(working.soft != 0, wall, value)) < -MULTIPLIER
    soft_outside = _sides_outside(value, qp.soft_lower, qp.soft_upper, FEASIBILITY)
    soft_added = (working.soft == 0) & (soft_outside != 0)
    working.soft[soft_pulled] = 0
    working.soft[soft_added] = soft_outside[soft_added]
    return bool(pulled.any() or added.any() or soft_pulled.any() or soft_added.any())


def _freedom(qp: LevelQp, felt: NDArray[np.bool_], soft: Signs) -> Matrix:
    """Return the directions that change neither the optimum nor a row that presses on it.

    A row with a multiplier holds for every optimum of the level: to keep it as an inequality for
    the levels below would leave them a feasible set without interior, where solvers stall.
    """
    walls = factorise(qp.hard[felt], _ROW_TOLERANCE)
    objective, _ = _objective(qp, soft)
    null: Matrix = walls.null.dot(factorise(objective.dot(walls.null), qp.tolerance).null)
    return null


def _objective(qp: LevelQp, soft: Signs) -> tuple[Matrix, Vector]:
    """Return the equality objectives and the soft rows that are outside, as ``A z -> b``."""
    outside = np.flatnonzero(soft)
    if outside.size == 0:
        return qp.objective, qp.target
    wall = np.where(soft > 0, qp.soft_upper, qp.soft_lower)[outside]
    return np.concatenate((qp.objective, qp.soft[outside])), np.concatenate((qp.target, wall))


def _sides_outside(value: Vector, lower: Vector, upper: Vector, by: float) -> Signs:
    """Return -1 where value is below lower, +1 where it is above upper, by more than ``by``."""
    sides: Signs = (value > upper + by).astype(np.int8) - (value < lower - by).astype(np.int8)
    return sides
