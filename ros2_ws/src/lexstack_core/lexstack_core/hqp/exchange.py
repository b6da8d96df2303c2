"""The whole hierarchy at once, for a guess of which bounds and rows hold.

If the guess is right this is the exact optimum: one chain of least-squares problems, each in the
null space of those above, with the joints of the working set held at their bounds. Whether it is
right is decided by the optimality conditions of the hierarchy (Escande, Mansard and Wieber 2014):
chi is inside the box, and the multiplier of everything held is lexicographically positive, that
is, the highest level that feels it presses against it. A wrong guess is corrected by exchange:
what is violated is held, what is pulled away from its bound is released. This mostly ends after
one to three guesses; where it does not, the cascade of quadratic programs decides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack_core.hqp.factor import Factor, factorise
from lexstack_core.hqp.rows import FEASIBILITY, MULTIPLIER, LevelRows, Signs
from lexstack_core.linear import Matrix, Vector

Free = NDArray[np.intp] | None  # indices of the joints that are not held; None for all


@dataclass(slots=True)
class _Step:
    """One level of the chain.

    Attributes:
        rows: the objective rows, all columns, shape (m, n).
        target: shape (m,).
        chosen: which rows of the level these are, shape (m,); None for all, all of them equalities.
        basis: the free directions above this level, shape (free, r); None for all.
        factor: of the rows in these directions.
    """

    rows: Matrix
    target: Vector
    chosen: NDArray[np.intp] | None
    basis: Matrix | None
    factor: Factor


@dataclass(slots=True)
class _Guess:
    """What is held: joints at their bounds, and inequality rows of each level at theirs."""

    joints: Signs
    rows: list[Signs]


def solve_by_exchange(
    levels: list[LevelRows], lower: Vector, upper: Vector, held: Signs, rounds: int
) -> Vector | None:
    """Return the exact optimum chi, shape (n,), or None if no guess in ``rounds`` was right.

    Freedom that no level uses is spent on the smallest ``||chi||``.

    Args:
        levels: index 0 is the highest priority.
        lower: bounds of chi, shape (n,).
        upper: shape (n,).
        held: first guess of the bounds that hold, shape (n,).
        rounds: the number of guesses to try.
    """
    fixed = upper - lower <= FEASIBILITY
    joints = np.where(fixed, np.int8(1), held)
    guess = _Guess(joints, [np.zeros(level.lower.size, dtype=np.int8) for level in levels])
    for _ in range(rounds):
        free = np.flatnonzero(guess.joints == 0) if guess.joints.any() else None
        chi, steps, rest = _chain(levels, lower, upper, guess, free)
        changed = _release(steps, chi, guess, free, rest, fixed)
        changed |= _hold(levels, chi, lower, upper, guess)
        if not changed:
            return chi
    return None


def _chain(
    levels: list[LevelRows], lower: Vector, upper: Vector, guess: _Guess, free: Free
) -> tuple[Vector, list[_Step], Matrix | None]:
    """Return the lexicographic least-squares point of a guess, its steps and the freedom left."""
    chi = np.zeros(lower.size)
    if free is not None:
        chi = np.where(guess.joints > 0, upper, np.where(guess.joints < 0, lower, chi))
    basis: Matrix | None = None
    steps: list[_Step] = []
    for level, sides in zip(levels, guess.rows, strict=True):
        rows, target, chosen = level.objective(sides)
        reduced = rows if free is None else rows.take(free, axis=1)
        if basis is not None:
            reduced = reduced.dot(basis)
        factor = factorise(reduced, level.tolerance)
        steps.append(_Step(rows, target, chosen, basis, factor))
        if factor.rank > 0:
            move = factor.solve(target - rows.dot(chi))
            move = move if basis is None else basis.dot(move)
            if free is None:
                chi += move
            else:
                chi[free] += move
            basis = factor.null if basis is None else basis.dot(factor.null)
    return chi, steps, basis


def _hold(
    levels: list[LevelRows], chi: Vector, lower: Vector, upper: Vector, guess: _Guess
) -> bool:
    """Hold what chi violates; return whether there was anything."""
    changed = _hold_violated(chi, lower, upper, guess.joints)
    for level, sides in zip(levels, guess.rows, strict=True):
        if not level.exact:
            value = level.matrix.dot(chi)
            value[level.equal] = level.lower[level.equal]
            changed |= _hold_violated(value, level.lower, level.upper, sides)
    return changed


def _hold_violated(value: Vector, lower: Vector, upper: Vector, sides: Signs) -> bool:
    """Set the side of every value that is outside and free; return whether there was one."""
    above = value - upper
    below = lower - value
    outside = np.maximum(above, below)
    outside[sides != 0] = 0.0
    if outside.max(initial=0.0) <= FEASIBILITY:
        return False
    violated = outside > FEASIBILITY
    sides[violated] = np.where(above > below, 1, -1)[violated]
    return True


def _release(
    steps: list[_Step],
    chi: Vector,
    guess: _Guess,
    free: Free,
    rest: Matrix | None,
    fixed: NDArray[np.bool_],
) -> bool:
    """Release what the highest level that feels it pulls inside; return whether there was any.

    Level by level, the gradient of the level's objective is balanced by multipliers of the rows
    above it; what remains of it acts on the joints that are held. A joint or row is judged by the
    first level whose multiplier of it is not zero.
    """
    pending = _Guess(np.where(fixed, np.int8(0), guess.joints), [s.copy() for s in guess.rows])
    if not pending.joints.any() and not any(sides.any() for sides in pending.rows):
        return False
    changed = False
    for k, step in enumerate(steps):
        residual = step.rows.dot(chi) - step.target
        if residual.dot(residual) <= MULTIPLIER * MULTIPLIER:
            continue
        if step.chosen is not None:
            changed |= _judge(guess.rows[k], pending.rows[k], residual, step.chosen)
        changed |= _balance(residual.dot(step.rows), steps[:k], guess, pending, free)
    # The last level is ||chi||; it also feels what was held without need.
    changed |= _balance(chi.copy(), steps, guess, pending, free)
    return changed


def _balance(
    gradient: Vector, above: list[_Step], guess: _Guess, pending: _Guess, free: Free
) -> bool:
    """Balance a level's gradient by the rows above it, lowest first, and judge what is held."""
    changed = False
    for j in range(len(above) - 1, -1, -1):
        step = above[j]
        if step.factor.rank == 0:
            continue
        local = gradient if free is None else gradient[free]
        multiplier = step.factor.solve_transposed(
            local if step.basis is None else local.dot(step.basis)
        )
        gradient -= multiplier.dot(step.rows)
        if step.chosen is not None:
            changed |= _judge(guess.rows[j], pending.rows[j], -multiplier, step.chosen)
    return _judge(guess.joints, pending.joints, -gradient, None) or changed


def _judge(
    sides: Signs, pending: Signs, outward: Vector, chosen: NDArray[np.intp] | None
) -> bool:
    """Decide what is pending by how hard it is pressed outward; return whether any is released."""
    if chosen is not None:
        spread = np.zeros(sides.size)
        spread[chosen] = outward
        outward = spread
    pressed = pending * outward
    felt = np.abs(pressed) > MULTIPLIER
    if not felt.any():
        return False
    pending[felt] = 0
    pulled = pressed < -MULTIPLIER
    sides[pulled] = 0
    return bool(pulled.any())
