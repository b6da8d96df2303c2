"""The strict solver as one compiled call: an active set is guessed, judged and exchanged.

A guess holds joints at their bounds and inequality rows at their ends, as equations. One
factorisation gives its optimum, one sweep the forces of every level on what is held. The guess is
right where nothing is violated and, on everything held, the first force that is not zero presses
outward (Escande, Mansard and Wieber 2014; ``docs/hqp.md`` says why). All that is wrong is exchanged
at once; after a few guesses in vain one change at a time, which ends where blocks go in circles.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled, entry
from lexstack.hqp.kernel.guess import forces, hold, point, release
from lexstack.hqp.kernel.usable import deciding_levels, usable
from lexstack.hqp.kernel.values import (
    INSIDE,
    ROUNDING,
    Box,
    Flags,
    Guess,
    Places,
    Rows,
    Signs,
    length_of,
    workspace,
)
from lexstack.types import Matrix, Vector

_BLOCKS = 6  # guesses that exchange all that is wrong
_GUESSES = 60  # of all; another solver does the rest


@compiled
def prepare(rows: Rows, box: Box, guess: Guess, bottom: int) -> None:
    """Make a guess one of this problem: joints that cannot move are held, endless ends are not."""
    for j in range(guess.held.size):
        if box.fixed[j]:
            guess.held[j] = 1
        end = box.high[j] if guess.held[j] > 0 else box.low[j]
        if not abs(end) < np.inf:
            guess.held[j] = 0
    for i in range(guess.sides.size):
        end = rows.upper[i] if guess.sides[i] > 0 else rows.lower[i]
        if i >= bottom or rows.lower[i] == rows.upper[i] or not abs(end) < np.inf:
            guess.sides[i] = 0


@compiled
def finish(rows: Rows, box: Box, guess: Guess, chi: Vector, slacks: Vector, inside: float) -> None:
    """Put chi into its box exactly; set the slacks, and where joints and rows are at an end."""
    for j in range(chi.size):
        chi[j] = min(max(chi[j], box.low[j]), box.high[j])
        guess.held[j] = 0
        if chi[j] - box.low[j] <= INSIDE:
            guess.held[j] = -1
        if box.high[j] - chi[j] <= INSIDE:
            guess.held[j] = 1
    start = 0
    for k in range(rows.ends.size):
        square = 0.0
        for i in range(start, rows.ends[k]):
            value = 0.0
            for j in range(chi.size):
                value += rows.matrix[i, j] * chi[j]
            gap = value - min(max(value, rows.lower[i]), rows.upper[i])
            square += gap * gap
            guess.sides[i] = 0
            if rows.lower[i] != rows.upper[i]:
                if value <= rows.lower[i] + inside:
                    guess.sides[i] = -1
                if value >= rows.upper[i] - inside:
                    guess.sides[i] = 1
        slacks[k] = math.sqrt(square)
        start = rows.ends[k]


@entry(
    "boolean(Array(float64, 2, 'C', readonly=True), Array(float64, 1, 'C', readonly=True), "
    "Array(float64, 1, 'C', readonly=True), Array(int64, 1, 'C', readonly=True), "
    "Array(boolean, 1, 'C', readonly=True), Array(float64, 1, 'C', readonly=True), "
    "Array(float64, 1, 'C', readonly=True), int8[::1], int8[::1], float64[::1], float64[::1])"
)
def solve(
    matrix: Matrix,
    lower: Vector,
    upper: Vector,
    ends: Places,
    curved: Flags,
    low: Vector,
    high: Vector,
    held: Signs,
    sides: Signs,
    chi: Vector,
    slacks: Vector,
) -> bool:
    """Solve a hierarchy of n > 0 joints; return whether it was.

    It is not where the problem has no answer, where rows or columns differ so much in size that
    they need scaling, or where no guess was right.

    Args:
        matrix: of all levels, shape (m, n).
        lower: shape (m,); equality objectives have lower == upper.
        upper: shape (m,).
        ends: one past the last row of each level.
        curved: whether each row is of a Jacobian, shape (m,).
        low: bounds of chi, shape (n,).
        high: shape (n,).
        held: the guess, -1, 0, +1 per joint; afterwards which bounds chi is at.
        sides: the guess, -1, 0, +1 per row; afterwards the ends at or beyond which rows are.
        chi: the optimum, shape (n,).
        slacks: norm of each level's residual.
    """
    rows = Rows(matrix, lower, upper, ends)
    if not usable(rows, curved, low, high):
        return False
    n = chi.size
    nearest = np.zeros(n)
    deciding = deciding_levels(rows, nearest)
    bottom = ends[deciding - 1] if deciding else 0
    box, guess = Box(low, high, high - low <= INSIDE), Guess(held, sides)
    prepare(rows, box, guess, bottom)
    at = workspace(rows, deciding)
    pushed = np.empty((deciding + 1, n + bottom))
    for turn in range(_GUESSES):
        single = turn >= _BLOCKS
        point(rows, box, guess, nearest, at, chi)
        length = length_of(chi)
        if not length < np.inf:
            return False
        inside = max(INSIDE, ROUNDING * length)
        changed = hold(rows, box, guess, bottom, chi, inside, single)
        if not (single and changed):
            zeros = forces(rows, guess, nearest, at, chi, pushed)
            changed += release(guess, box, pushed, zeros, single)
        if not changed:
            finish(rows, box, guess, chi, slacks, inside)
            return True
    return False
