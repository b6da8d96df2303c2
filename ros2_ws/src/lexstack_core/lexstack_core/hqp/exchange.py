"""The whole hierarchy at once, for a guess of which bounds and rows hold.

If the guess is right this is the exact optimum: one chain of least-squares problems, each in the
null space of those above, with the joints of the working set held at their bounds. Whether it is
right is decided by the optimality conditions of the hierarchy (Escande, Mansard and Wieber 2014):
chi is inside the box, and the multiplier of everything held is lexicographically positive, that
is, the highest level that feels it presses against it. A wrong guess is corrected by exchange:
what is violated is held, what is pulled away from its bound is released.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lexstack_core.hqp.factor import Factor, factorise
from lexstack_core.hqp.rows import (
    FEASIBILITY,
    MULTIPLIER,
    Hierarchy,
    Indices,
    LevelRows,
    Mask,
    Signs,
)
from lexstack_core.linear import Matrix, Vector


@dataclass(slots=True)
class Guess:
    """What is held: joints at their bounds, shape (n,), and rows of each level at their ends."""

    joints: Signs
    rows: list[Signs]

    @classmethod
    def of(cls, levels: list[LevelRows], joints: Signs) -> Guess:
        """Return the guess that these joints and no inequality rows are held."""
        return cls(joints, [np.zeros(level.lower.size, dtype=np.int8) for level in levels])

    @classmethod
    def split(cls, hierarchy: Hierarchy, sides: Signs) -> Guess:
        """Return the guess of one vector: first the joints, then all inequality rows."""
        n = hierarchy.matrix.shape[1]
        guess = cls.of(hierarchy.levels, sides[:n])
        if not hierarchy.exact:
            for level, held in zip(hierarchy.levels, guess.rows, strict=True):
                rows = np.flatnonzero(~level.equal)
                held[rows] = sides[n : n + rows.size]
                n += rows.size
        return guess


@dataclass(slots=True)
class _Step:
    """One level of the chain.

    Attributes:
        rows: the objective rows, all columns, shape (m, n).
        target: shape (m,).
        chosen: which rows of the level these are, shape (m,); None for all.
        basis: the free directions above this level, shape (free, r); None for all.
        factor: of the rows in these directions.
    """

    rows: Matrix
    target: Vector
    chosen: Indices | None
    basis: Matrix | None
    factor: Factor


def solve_by_exchange(
    levels: list[LevelRows], lower: Vector, upper: Vector, guess: Guess, rounds: int
) -> Vector | None:
    """Return the exact optimum chi, shape (n,), or None if no guess in ``rounds`` was right.

    Freedom that no level uses is spent on the smallest ``||chi||``.

    Args:
        levels: index 0 is the highest priority.
        lower: bounds of chi, shape (n,).
        upper: shape (n,).
        guess: what probably holds; it is left as the last one tried.
        rounds: the number of guesses to try.
    """
    fixed = upper - lower <= FEASIBILITY
    guess.joints = np.where(fixed, np.int8(1), guess.joints)
    for left in range(rounds - 1, -1, -1):
        chi = _on_bounds(guess.joints, lower, upper)
        free = np.flatnonzero(guess.joints == 0) if guess.joints.any() else None
        steps = _chain(levels, guess, free, chi)
        if not math.isfinite(chi.dot(chi)):
            return None
        outside = _hold(levels, chi, lower, upper, guess)
        if outside and left == 0:
            return None
        if not _release(steps, chi, guess, free, fixed) and not outside:
            return chi
    return None


def _on_bounds(joints: Signs, lower: Vector, upper: Vector) -> Vector:
    """Return chi with the held joints at their bounds and zeros; frees what has no such bound."""
    chi = np.where(joints > 0, upper, np.where(joints < 0, lower, 0.0))
    if not math.isfinite(chi.dot(chi)):
        joints[~np.isfinite(chi)] = 0
        chi[joints == 0] = 0.0
    return chi


def _chain(levels: list[LevelRows], guess: Guess, free: Indices | None, chi: Vector) -> list[_Step]:
    """Move chi to the lexicographic least-squares point of a guess; return the steps to it."""
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
    return steps


def _hold(levels: list[LevelRows], chi: Vector, lower: Vector, upper: Vector, guess: Guess) -> bool:
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
    if outside.max(initial=0.0) <= FEASIBILITY:
        return False
    violated = (outside > FEASIBILITY) & (sides == 0)
    sides[violated] = np.where(above > below, 1, -1)[violated]
    return bool(violated.any())


def _release(
    steps: list[_Step], chi: Vector, guess: Guess, free: Indices | None, fixed: Mask
) -> bool:
    """Release what the highest level that feels it pulls inside; return whether there was any.

    The gradient of each level's objective is balanced by multipliers of the rows above it; what
    remains of it acts on the joints that are held. Below the last level there is ||chi||, which
    feels what is held without need. All levels are balanced in one sweep: row k of ``gradient``
    and of each ``forces`` belongs to level k.
    """
    if free is None and not any(sides.any() for sides in guess.rows):
        return False
    gradient = np.empty((len(steps) + 1, chi.size))
    gradient[-1] = chi
    changed = False
    for j in range(len(steps) - 1, -1, -1):
        step = steps[j]
        residual = step.rows.dot(chi) - step.target
        gradient[j] = residual.dot(step.rows)
        below = gradient[j + 1 :]
        local = below if free is None else below.take(free, axis=1)
        if step.basis is not None:
            local = local.dot(step.basis)
        multipliers = step.factor.solve_transposed(local)
        below -= multipliers.dot(step.rows)
        if step.chosen is not None:
            forces = np.zeros((len(multipliers) + 1, guess.rows[j].size))
            forces[0, step.chosen] = residual
            forces[1:, step.chosen] = -multipliers
            changed |= _judge(guess.rows[j], guess.rows[j], forces)
    judged = np.where(fixed, np.int8(0), guess.joints)
    return _judge(guess.joints, judged, -gradient) or changed


def _judge(sides: Signs, judged: Signs, forces: Matrix) -> bool:
    """Release what is pulled by the first force on it that is not zero; return whether any is.

    Args:
        sides: shape (m,), of joints or of the rows of a level; zero where released.
        judged: those that may be released, shape (m,).
        forces: outward, in the order of the levels, shape (levels, m).
    """
    pressed = forces * judged
    felt = np.abs(pressed) > MULTIPLIER
    first = pressed[felt.argmax(axis=0), np.arange(judged.size)]
    pulled = first < -MULTIPLIER
    sides[pulled] = 0
    return bool(pulled.any())
