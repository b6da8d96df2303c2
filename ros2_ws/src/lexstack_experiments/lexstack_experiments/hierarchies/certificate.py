"""How far a chi may be from the strict optimum: a bound by weak duality, level by level.

The objective of level k, f(x) = ||dist(A_k x, [lower, upper])||^2 / 2, is convex. With r its
residual at chi and g = A_k^T r, every other x has f(x) >= f(chi) + g (x - chi). The levels above
leave x the set where what they reached stays reached: C x = C chi for equality rows and rows out of
their interval, E x inside its interval for the others. Any multipliers mu, nu split

    -g = C^T mu + E^T nu + lambda

and then g (x - chi) >= -sum max(lambda_i d_i) - sum max(nu_j e_j), over the box of chi and the
intervals of E. That holds whatever the multipliers are: bad ones give a weak bound, never a wrong
one. So nothing of the solver needs to be trusted, and no second solver is needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from lexstack.hqp import HqpProblem
from lexstack.types import Matrix, Vector

_TOUCH = 1e-9  # nearer than this to its end, a joint or row may be pressed
_TINY = 1e-20  # of the objective: a smaller gap needs no better multipliers

Mask = NDArray[np.bool_]
Box = tuple[Vector, Vector]


@dataclass(slots=True)
class _Above:
    """What the levels above leave: C x as it is, E x between two ends (from where it is)."""

    kept: Matrix  # C, shape (p, n)
    inherited: Matrix  # E, shape (q, n)
    low: Vector  # shape (q,), at most 0
    high: Vector  # shape (q,), at least 0


def certified_excess(problem: HqpProblem, chi: Vector) -> list[float]:
    """Return, for each level, what its residual at chi exceeds its least possible one by, at most.

    The least is over all points of the box that leave the levels above as chi has them.

    Args:
        problem: with finite bounds.
        chi: inside the bounds, shape (n,).
    """
    n = chi.size
    box = np.minimum(problem.bounds.lower - chi, 0.0), np.maximum(problem.bounds.upper - chi, 0.0)
    above = _Above(np.empty((0, n)), np.empty((0, n)), np.empty(0), np.empty(0))
    found = []
    for level in problem.levels:
        matrix = np.vstack([np.empty((0, n)), *(task.matrix for task in level)])
        lower = np.concatenate([np.empty(0), *(task.lower for task in level)])
        upper = np.concatenate([np.empty(0), *(task.upper for task in level)])
        value = matrix @ chi
        residual = value - np.clip(value, lower, upper)
        gap = _gap(residual @ matrix, above, box)
        norm = float(np.linalg.norm(residual))
        found.append(norm - float(np.sqrt(max(norm * norm - 2.0 * gap, 0.0))))
        above = _below(above, matrix, (lower - value, upper - value), residual)
    return found


def _below(above: _Above, matrix: Matrix, ends: tuple[Vector, Vector], residual: Vector) -> _Above:
    """Return what is left below a level."""
    lower, upper = ends
    kept = (lower == upper) | (np.abs(residual) > 1e-11)
    return _Above(
        np.vstack([above.kept, matrix[kept]]),
        np.vstack([above.inherited, matrix[~kept]]),
        np.concatenate([above.low, np.minimum(lower[~kept], 0.0)]),
        np.concatenate([above.high, np.maximum(upper[~kept], 0.0)]),
    )


def _gap(gradient: Vector, above: _Above, box: Box) -> float:
    """Return how much the objective can fall at most, by the best multipliers that are found."""
    # What is touched may be pressed. Where too much is touched for one solution, a linear program
    # says what is.
    none = np.zeros(len(above.kept)), np.zeros(above.low.size)
    pressed = (box[0] > -_TOUCH) | (box[1] < _TOUCH), (above.low > -_TOUCH) | (above.high < _TOUCH)
    multipliers = _balance(gradient, above, pressed, none)
    gap = _bound(gradient, above, box, *multipliers)
    # Forces on what is free are chi's fault; forces that pull what is touched may be ours.
    low, high = (np.where(pressed[0], 0.0, end) for end in box)
    inherited = (np.where(pressed[1], 0.0, end) for end in (above.low, above.high))
    held = _Above(above.kept, above.inherited, *inherited)
    if gap - _bound(gradient, held, (low, high), *multipliers) <= _TINY:
        return gap
    first, pressed = _programmed(gradient, above, box)
    return min(gap, _bound(gradient, above, box, *_balance(gradient, above, pressed, first)))


def _bound(gradient: Vector, above: _Above, box: Box, mu: Vector, nu: Vector) -> float:
    """Return the bound that some multipliers give."""
    # An end without limit allows one sign only.
    nu = np.where(np.isinf(above.high), np.minimum(nu, 0.0), nu)
    nu = np.where(np.isinf(above.low), np.maximum(nu, 0.0), nu)
    rest = -(gradient + mu @ above.kept + nu @ above.inherited)
    ends = (np.concatenate([box[0], above.low]), np.concatenate([box[1], above.high]))
    forces = np.concatenate([rest, nu])
    end = np.where(forces > 0.0, ends[1], ends[0])
    pressed = forces != 0.0
    return float(forces[pressed] @ end[pressed])


def _balance(
    gradient: Vector, above: _Above, pressed: tuple[Mask, Mask], first: tuple[Vector, Vector]
) -> tuple[Vector, Vector]:
    """Return the multipliers next to the first ones that leave no force but where it may press."""
    joints, inherited = pressed
    mu, nu = first[0].copy(), np.where(inherited, first[1], 0.0)
    rest = -(gradient + mu @ above.kept + nu @ above.inherited)
    rows = np.vstack([above.kept, above.inherited[inherited]])
    found = np.linalg.lstsq(rows[:, ~joints].T, rest[~joints], rcond=1e-13)[0]
    mu += found[: mu.size]
    nu[inherited] += found[mu.size :]
    return mu, nu


def _programmed(
    gradient: Vector, above: _Above, box: Box
) -> tuple[tuple[Vector, Vector], tuple[Mask, Mask]]:
    """Return the multipliers of the least bound by a linear program, and what they press."""
    n, p, q = gradient.size, len(above.kept), above.low.size
    scale = float(np.abs(gradient).max(initial=0.0)) or 1.0
    sides = np.vstack([np.eye(n), above.inherited])
    cost = np.concatenate([box[1], above.high, -box[0], -above.low])
    never = np.isinf(cost)
    result = linprog(
        np.concatenate([np.zeros(p), np.where(never, 0.0, cost)]),
        A_eq=np.vstack([above.kept, sides, -sides]).T,
        b_eq=-gradient / scale,
        bounds=[(None, None)] * p + [(0.0, 0.0 if no else None) for no in never],
    )
    if result.x is None:
        every = np.ones(n, dtype=bool), np.ones(q, dtype=bool)
        return (np.zeros(p), np.zeros(q)), every
    up, down = np.split(result.x[p:], 2)
    felt = up + down > 1e-12
    return (scale * result.x[:p], scale * (up - down)[n:]), (felt[:n], felt[n:])
