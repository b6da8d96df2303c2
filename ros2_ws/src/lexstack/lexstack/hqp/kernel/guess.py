"""A guess of the active set: its optimum, what that violates, and what it need not hold."""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled
from lexstack.hqp.kernel.lq import factorise, multipliers, settle, turned_back
from lexstack.hqp.kernel.values import ROUNDING, ZERO, Box, Factors, Guess, Rows, length_of
from lexstack.types import Matrix, Vector


@compiled
def point(rows: Rows, box: Box, guess: Guess, nearest: Vector, at: Factors, chi: Vector) -> None:
    """Set chi, shape (n,), to the optimum of a guess, with the factorisation that leads there.

    Args:
        rows: of all levels.
        box: of chi.
        guess: what is held, as equations.
        nearest: where chi begins, shape (n,): every level moves it as little as possible.
        at: the workspace.
        chi: the optimum.
    """
    n, f = chi.size, 0
    for j in range(n):
        if guess.held[j] == 0:
            chi[j] = nearest[j]
            at.free[f] = j
            f += 1
        else:
            chi[j] = box.high[j] if guess.held[j] > 0 else box.low[j]
    count, start, levels = 0, 0, at.norms.size
    for k in range(levels):
        at.first[k] = count
        for i in range(start, rows.ends[k]):
            if rows.lower[i] == rows.upper[i] or guess.sides[i] != 0:
                for c in range(f):
                    at.work[count, c] = rows.matrix[i, at.free[c]]
                at.order[count] = i
                count += 1
        start = rows.ends[k]
    at.first[levels] = count
    at.used[0] = 0
    for k in range(levels):
        factorise(at, k, f)
        for a in range(at.first[k], at.first[k + 1]):
            i = at.order[a]
            total = rows.lower[i] if guess.sides[i] < 0 else rows.upper[i]
            for j in range(n):
                total -= rows.matrix[i, j] * chi[j]
            at.rest[a] = total
        settle(at, k)
    z = np.zeros(f)
    for c in range(at.used[levels]):
        z[c] = at.y[c]
    turned_back(at, z)
    for c in range(f):
        chi[at.free[c]] += z[c]


@compiled
def hold(
    rows: Rows, box: Box, guess: Guess, bottom: int, chi: Vector, inside: float, single: bool
) -> int:
    """Hold what chi violates by more than ``inside``, or only the first; return how much that is.

    Args:
        rows: of all levels.
        box: of chi.
        guess: changed in place.
        bottom: one past the last row of the deciding levels.
        chi: shape (n,).
        inside: how far outside still counts as inside.
        single: whether one change is enough.
    """
    changed = 0
    for j in range(chi.size):
        if guess.held[j] == 0 and not box.low[j] - inside <= chi[j] <= box.high[j] + inside:
            guess.held[j] = 1 if chi[j] > box.high[j] else -1
            changed += 1
            if single:
                return changed
    for i in range(bottom):
        if guess.sides[i] == 0 and rows.lower[i] != rows.upper[i]:
            value = 0.0
            for j in range(chi.size):
                value += rows.matrix[i, j] * chi[j]
            if not rows.lower[i] - inside <= value <= rows.upper[i] + inside:
                guess.sides[i] = 1 if value > rows.upper[i] else -1
                changed += 1
                if single:
                    return changed
    return changed


@compiled
def forces(
    rows: Rows, guess: Guess, nearest: Vector, at: Factors, chi: Vector, pushed: Matrix
) -> Vector:
    """Set the force of every level on everything held; return below which size it is zero.

    The gradient of level s, A_s^T (A_s chi - b_s), is balanced by multipliers of the levels above,
    from the next one up to the first; what remains acts on what is held, with the other sign. In
    the directions of the factorisation this is back substitution. The last force is that of the
    distance to where chi began, whose gradient is y itself.

    What counts as zero grows with the terms that went in: see ``judge.py``.

    Args:
        rows: of all levels.
        guess: what is held.
        nearest: where chi began, shape (n,).
        at: the factorisation at chi.
        chi: the optimum of the guess, shape (n,).
        pushed: outward forces, shape (levels + 1, n + m): of joints, then of rows.
    """
    levels, n = at.norms.size, chi.size
    length = length_of(chi)
    gradient, force, zeros = np.empty(n), np.empty(at.rest.size), np.empty(levels + 1)
    pushed[:] = 0.0
    for s in range(levels + 1):
        if s < levels:
            zeros[s] = level_force(rows, guess, at, s, length, gradient, pushed)
            if at.first[s + 1] - at.first[s] == at.used[s + 1] - at.used[s]:
                zeros[s] = max(ZERO, ROUNDING * zeros[s])
                continue  # it is met, and has no gradient
        else:
            zeros[s] = length
            for c in range(at.used[levels]):
                gradient[c] = at.y[c]
            for j in range(n):
                if guess.held[j] != 0:
                    pushed[s, j] = nearest[j] - chi[j]
        for k in range(s - 1, -1, -1):
            if at.used[k + 1] == at.used[k]:
                continue
            multipliers(at, k, gradient, force)
            total = 0.0
            for a in range(at.first[k], at.first[k + 1]):
                i = at.order[a]
                total += abs(force[a])
                for j in range(n):
                    if guess.held[j] != 0:
                        pushed[s, j] += rows.matrix[i, j] * force[a]
                if rows.lower[i] != rows.upper[i]:
                    pushed[s, n + i] = -force[a]
            zeros[s] += at.norms[k] * total
        zeros[s] = max(ZERO, ROUNDING * zeros[s])
    return zeros


@compiled
def level_force(
    rows: Rows, guess: Guess, at: Factors, s: int, length: float, gradient: Vector, pushed: Matrix
) -> float:
    """Set the gradient of level s and its own force; return the magnitude of their terms."""
    n = guess.held.size
    goal = 0.0
    for c in range(at.used[s]):
        gradient[c] = 0.0
    for a in range(at.first[s], at.first[s + 1]):
        i, value = at.order[a], at.rest[a]
        target = rows.lower[i] if guess.sides[i] < 0 else rows.upper[i]
        goal += target * target
        if value == 0.0:
            continue
        for c in range(at.used[s]):
            gradient[c] += at.work[a, c] * value
        for j in range(n):
            if guess.held[j] != 0:
                pushed[s, j] -= rows.matrix[i, j] * value
        if rows.lower[i] != rows.upper[i]:
            pushed[s, n + i] = value
    size = float(at.norms[s])
    return max(size, 1.0) * (size * length + math.sqrt(goal))


@compiled
def release(guess: Guess, box: Box, pushed: Matrix, zeros: Vector, single: bool) -> int:
    """Release what the first force that is not zero pulls inside, or only the first of it.

    Args:
        guess: changed in place.
        box: of chi; joints that cannot move stay held.
        pushed: outward forces, shape (levels + 1, n + m).
        zeros: below which size those of each level are zero.
        single: whether one change is enough.

    Returns:
        how many were released.
    """
    n, changed = guess.held.size, 0
    for c in range(pushed.shape[1]):
        side = guess.held[c] if c < n else guess.sides[c - n]
        if c < n and box.fixed[c]:
            continue
        if side == 0:
            continue
        for s in range(zeros.size):
            if abs(pushed[s, c]) > zeros[s]:
                if pushed[s, c] * side < 0.0:
                    if c < n:
                        guess.held[c] = 0
                    else:
                        guess.sides[c - n] = 0
                    changed += 1
                    if single:
                        return changed
                break
    return changed
