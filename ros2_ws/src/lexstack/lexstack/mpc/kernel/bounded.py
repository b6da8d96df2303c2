"""The QP by its active set: limits that a solution exceeds enter the pool, until none is left."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.active_set import backward, exchange, forward, settle, taken
from lexstack.mpc.kernel.parts import add_multipliers, all_values
from lexstack.mpc.kernel.pool import Pool, add_limit
from lexstack.mpc.kernel.schur import solve
from lexstack.mpc.kernel.values import Array, Gains, Places, Qp

_ROUNDS = 20
_BEYOND = 5e-10  # in the unit of a bound


class Holding(NamedTuple):
    """The bounds in the pool, shape (c,) each, and the factor of those that hold.

    Attributes:
        low: lower bounds.
        high: upper bounds.
        values: A d.
        sides: 1 where the upper one holds, -1 the lower, else 0; 2: depends on others.
        multipliers: y.
        held: which hold, in the order of the factor.
        factor: L of G of those that hold.
    """

    low: Array
    high: Array
    values: Array
    sides: Array
    multipliers: Array
    held: Places
    factor: Array


@compiled
def cost_alone(qp: Qp) -> Qp:
    """Return the QP without its bounded rows."""
    return Qp(
        qp.dt, qp.kappa, qp.gradient, qp.weights, qp.rows[: qp.soft], qp.stages[: qp.soft],
        qp.wide[:0], qp.soft, qp.fixed, qp.low, qp.high, qp.lower[:0], qp.upper[:0],
    )  # fmt: skip


@compiled
def guessed(
    qp: Qp, gains: Gains, pool: Pool, values: Array, low: Array, high: Array, y: Array
) -> tuple[Holding, int, int]:
    """Return what holds of a guess, y of shape (M,), with the pool's size and how many hold."""
    hard, size, space = qp.low.size, qp.lower.size, len(pool.gram)
    for bound in range(hard):
        end = high[bound] if y[bound] > 0.0 else low[bound]
        if y[bound] != 0.0 and math.isfinite(end) and size < space:
            add_limit(qp, gains, pool, size, bound)
            size += 1
    own = Holding(
        np.empty(space), np.empty(space), np.empty(space), np.zeros(space), np.zeros(space),
        np.zeros(space + 1, dtype=np.int64), np.zeros((space + 1, space + 1)),
    )  # fmt: skip
    count = 0
    for p in range(size):
        bound = pool.places[p]
        own.values[p], own.low[p], own.high[p] = values[bound], low[bound], high[bound]
        end = high[bound] if y[bound] > 0.0 else low[bound]
        if y[bound] == 0.0 or not math.isfinite(end):
            continue
        if taken(pool.gram, own.factor, own.held, count, p):
            own.sides[p] = 1.0 if y[bound] > 0.0 else -1.0
            count += 1
    count = settle(
        own.factor, own.held, own.sides, count, own.values, own.low, own.high, own.multipliers
    )
    return own, size, count


@compiled
def refined(pool: Pool, own: Holding, size: int, count: int) -> None:
    """Hold what holds to the last digit, with values as measured."""
    correction = np.empty(count)
    for i in range(count):
        row = own.held[i]
        end = own.high[row] if own.sides[row] > 0.0 else own.low[row]
        correction[i] = own.values[row] - end
        own.values[row] = end
    forward(own.factor, count, correction)
    backward(own.factor, count, correction)
    for i in range(count):
        own.multipliers[own.held[i]] += correction[i]
    for p in range(size):
        if own.sides[p] != 1.0 and own.sides[p] != -1.0:
            for i in range(count):
                own.values[p] -= pool.gram[p, own.held[i]] * correction[i]


@compiled
def active(qp: Qp, gains: Gains, pool: Pool, motion: Array, y: Array, most: int) -> int:
    """Solve the QP.

    Args:
        qp: the QP.
        gains: of B without limits.
        pool: of ``begun``, reduced.
        motion: where the cost alone is least, shape (3, N, n); then the solution.
        y: signs of what probably holds, shape (M,); then the multipliers.
        most: changes of what holds.

    Returns:
        How many changes it took, or -1 where it did not come to an end.
    """
    hard, space = qp.low.size, len(pool.gram)
    low = np.concatenate((qp.low.copy().reshape(-1), qp.lower))
    high = np.concatenate((qp.high.copy().reshape(-1), qp.upper))
    values = np.empty(y.size)
    all_values(qp, motion, values)
    own, size, count = guessed(qp, gains, pool, values, low, high, y)
    free, least = cost_alone(qp), motion.copy()
    force, response, right = np.empty(motion.shape), np.empty(motion.shape), np.empty(qp.soft)
    changes, known = 0, size
    for turn in range(_ROUNDS):
        y[:] = 0.0
        if turn > 0 or count > 0:
            for p in range(size):
                y[pool.places[p]] = own.multipliers[p]
            force[:] = 0.0
            add_multipliers(qp, y, -1.0, force)
            right[:] = 0.0
            solve(free, gains, pool.joined, force, right, response)
            motion[:] = least + response
            all_values(qp, motion, values)
        for bound in range(hard):
            beyond = max(values[bound] - high[bound], low[bound] - values[bound])
            if beyond > _BEYOND and pool.of_bound[bound] < 0:
                if size == space:
                    return -1
                add_limit(qp, gains, pool, size, bound)
                own.low[size], own.high[size] = low[bound], high[bound]
                size += 1
        worst = 0.0
        for p in range(size):
            own.values[p] = values[pool.places[p]]
            worst = max(worst, own.values[p] - own.high[p], own.low[p] - own.values[p])
        if size == known and worst <= _BEYOND:
            return changes
        known = size
        refined(pool, own, size, count)
        count, more = exchange(
            pool.gram, size, own.factor, own.held, own.sides, count,
            own.values, own.low, own.high, own.multipliers, most - changes,
        )  # fmt: skip
        if more < 0:
            return -1
        changes += more
    return -1
