"""The dual active set method of Goldfarb and Idnani on the ``pool``: which bounds hold.

Beginning with the least of the cost alone, the bound that is exceeded most is added to those that
hold; on the way multipliers of others may become 0, and these are let go. Every step raises the
cost, so no set returns. The Cholesky factor of G of the bounds that hold grows by a row for each
one added, and shrinks by rotations.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.values import Array, Places

_EXCEEDED = 1e-10  # for rows of length 1 in the metric of H,
_ROOM = 1e-10  # m, rad ... that every row may be exceeded: some hardly change whatever d is
_DEPENDENT = 1e-11  # of a row's square: what is left of it beside those that hold
_FORGIVEN = 1e-8  # so much a row may be exceeded that depends on others
_POINT = 1e-9


@compiled
def forward(factor: Array, count: int, values: Array) -> None:
    """Replace b by L^-1 b, of the first rows."""
    for i in range(count):
        total = values[i]
        row = factor[i]
        for j in range(i):
            total -= row[j] * values[j]
        values[i] = total / row[i]


@compiled
def backward(factor: Array, count: int, values: Array) -> None:
    """Replace b by L^-T b, of the first rows."""
    for i in range(count - 1, -1, -1):
        row = factor[i]
        value = values[i] / row[i]
        values[i] = value
        for j in range(i):
            values[j] -= value * row[j]


@compiled
def dropped(factor: Array, count: int, place: int) -> None:
    """Take the row ``place`` out of L, of the first rows, by rotations of its columns."""
    for i in range(place, count - 1):
        for j in range(i + 2):
            factor[i, j] = factor[i + 1, j]
    for c in range(place, count - 1):
        a, b = factor[c, c], factor[c, c + 1]
        length = math.hypot(a, b)
        cos, sin = a / length, b / length
        factor[c, c] = length
        factor[c, c + 1] = 0.0
        for i in range(c + 1, count - 1):
            a, b = factor[i, c], factor[i, c + 1]
            factor[i, c] = cos * a + sin * b
            factor[i, c + 1] = cos * b - sin * a


@compiled
def let_go(
    factor: Array, held: Places, sides: Array, multipliers: Array, count: int, place: int
) -> int:
    """Let a bound go; return how many still hold."""
    dropped(factor, count, place)
    multipliers[held[place]] = 0.0
    sides[held[place]] = 0.0
    for i in range(place, count - 1):
        held[i] = held[i + 1]
    return count - 1


@compiled
def taken(gram: Array, factor: Array, held: Places, count: int, row: int) -> bool:
    """Continue L by a row of G; False: the row depends on those that hold."""
    own = factor[count]
    for i in range(count):
        own[i] = gram[row, held[i]]
    forward(factor, count, own)
    left = gram[row, row]
    for i in range(count):
        left -= own[i] * own[i]
    if not left > _DEPENDENT * gram[row, row]:
        return False
    own[count] = math.sqrt(left)
    held[count] = row
    return True


@compiled
def settle(
    factor: Array, held: Places, sides: Array, count: int,
    free: Array, low: Array, high: Array, multipliers: Array,
) -> int:  # fmt: skip
    """Find the multipliers of what holds; let go of wrong signs; return how many hold.

    ``free`` are the values without multipliers, A d_0.
    """
    values = np.empty(len(factor))
    while count > 0:
        for i in range(count):
            row = held[i]
            values[i] = free[row] - (high[row] if sides[row] > 0.0 else low[row])
        forward(factor, count, values)
        backward(factor, count, values)
        wrong = 0
        for i in range(count - 1, -1, -1):
            row = held[i]
            multipliers[row] = values[i]
            if sides[row] * values[i] < 0.0 and high[row] - low[row] > _POINT:
                wrong += 1
                count = let_go(factor, held, sides, multipliers, count, i)
        if not wrong:
            break
    return count


@compiled
def exchange(
    gram: Array, size: int, factor: Array, held: Places, sides: Array, count: int,
    values: Array, low: Array, high: Array, multipliers: Array, most: int,
) -> tuple[int, int]:  # fmt: skip
    """Add and let go of bounds until none is exceeded.

    Args:
        gram: G, of which the first ``size`` rows count.
        size: rows in the pool.
        factor: L of what holds; changed.
        held: which rows hold, in the order of L; changed.
        sides: 1 where a row holds at its upper bound, -1 at its lower, else 0; changed.
        count: how many hold.
        values: A d; changed.
        low: of the rows.
        high: of the rows.
        multipliers: y; changed.
        most: changes.

    Returns:
        How many hold, and how many changes were made; -1 where it does not come to an end.
    """
    step = np.empty(len(factor))
    for change in range(most):
        worst, row, side = _EXCEEDED, -1, 0.0
        for p in range(size):
            if sides[p] == 0.0 and gram[p, p] > 1e-26:
                beyond = max(values[p] - high[p], low[p] - values[p]) - _ROOM
                if beyond > 0.0:
                    beyond /= math.sqrt(gram[p, p])
                    if beyond > worst:
                        worst, row = beyond, p
                        side = 1.0 if values[p] > high[p] else -1.0
        if row < 0:
            return count, change
        while True:
            # y of the row grows by t, those that hold change by -t r, and values by -t z.
            if count + 1 >= len(factor):
                return count, -1
            new = taken(gram, factor, held, count, row)
            for i in range(count):
                step[i] = factor[count, i]
            backward(factor, count, step)
            square = factor[count, count] * factor[count, count] if new else 0.0
            excess = values[row] - (high[row] if side > 0.0 else low[row])
            length = abs(excess) / square if new else math.inf
            blocking = -1
            for i in range(count):
                other = held[i]
                if high[other] - low[other] > _POINT:
                    rate = sides[other] * side * step[i]
                    if rate > 0.0 and sides[other] * multipliers[other] < length * rate:
                        length = max(0.0, sides[other] * multipliers[other] / rate)
                        blocking = i
            if not math.isfinite(length):
                if worst > _FORGIVEN:
                    return count, -1
                sides[row] = 2.0
                break
            signed = side * length
            multipliers[row] += signed
            for i in range(count):
                multipliers[held[i]] -= signed * step[i]
            if new:
                for p in range(size):
                    values[p] -= signed * gram[row, p]
                for i in range(count):
                    by = signed * step[i]
                    across = gram[held[i]]
                    for p in range(size):
                        values[p] += by * across[p]
            if blocking < 0:
                sides[row] = side
                count += 1
                break
            count = let_go(factor, held, sides, multipliers, count, blocking)
    return count, -1
