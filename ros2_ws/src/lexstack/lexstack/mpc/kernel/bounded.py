"""The QP by its active set: the limits that a solution exceeds enter the pool, until none is left."""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.active_set import backward, exchange, forward, settle, taken
from lexstack.mpc.kernel.parts import add_multipliers, all_values
from lexstack.mpc.kernel.pool import Pool, add_limit
from lexstack.mpc.kernel.schur import solve
from lexstack.mpc.kernel.values import Array, Gains, Qp

_ROUNDS = 20
_BEYOND = 5e-10  # in the unit of a bound


@compiled
def cost_alone(qp: Qp) -> Qp:
    """Return the QP without its bounded rows."""
    return Qp(
        qp.dt, qp.kappa, qp.gradient, qp.weights, qp.rows[: qp.soft], qp.stages[: qp.soft],
        qp.wide[:0], qp.soft, qp.fixed, qp.low, qp.high, qp.lower[:0], qp.upper[:0],
    )  # fmt: skip


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
    hard = qp.low.size
    free = cost_alone(qp)
    size, space = qp.lower.size, len(pool.gram)
    bounds = y.size
    low, high = np.empty(bounds), np.empty(bounds)
    low[:hard], high[:hard] = qp.low.reshape(-1), qp.high.reshape(-1)
    low[hard:], high[hard:] = qp.lower, qp.upper
    values = np.empty(bounds)
    all_values(qp, motion, values)
    for bound in range(hard):
        end = high[bound] if y[bound] > 0.0 else low[bound]
        if y[bound] != 0.0 and math.isfinite(end) and size < space:
            add_limit(qp, gains, pool, size, bound)
            size += 1
    own_low, own_high, own = np.empty(space), np.empty(space), np.empty(space)
    sides, multipliers = np.zeros(space), np.zeros(space)
    factor, held = np.zeros((space + 1, space + 1)), np.zeros(space + 1, dtype=np.int64)
    count, known, changes = 0, 0, 0
    for p in range(size):
        bound = pool.places[p]
        own[p], own_low[p], own_high[p] = values[bound], low[bound], high[bound]
        if y[bound] != 0.0 and taken(pool.gram, factor, held, count, p):
            sides[p] = 1.0 if y[bound] > 0.0 else -1.0
            if math.isfinite(own_high[p] if sides[p] > 0.0 else own_low[p]):
                count += 1
            else:
                sides[p] = 0.0
    known = size
    count = settle(pool.gram, factor, held, sides, count, own, own_low, own_high, multipliers)
    least = motion.copy()
    _, stages, n = motion.shape
    force, response = np.empty((3, stages, n)), np.empty((3, stages, n))
    right = np.empty(qp.soft)
    y[:] = 0.0
    started = count > 0
    for _ in range(_ROUNDS):
        if started:
            y[:] = 0.0
            for p in range(size):
                y[pool.places[p]] = multipliers[p]
            force[:] = 0.0
            add_multipliers(qp, y, -1.0, force)
            right[:] = 0.0
            solve(free, gains, pool.joined, force, right, response)
            motion[:] = least + response
            all_values(qp, motion, values)
        started = True
        for bound in range(hard):
            beyond = max(values[bound] - high[bound], low[bound] - values[bound])
            if beyond > _BEYOND and pool.of_bound[bound] < 0:
                if size == space:
                    return -1
                add_limit(qp, gains, pool, size, bound)
                own_low[size], own_high[size] = low[bound], high[bound]
                size += 1
        off = 0.0
        for p in range(size):
            own[p] = values[pool.places[p]]
            off = max(off, own[p] - own_high[p], own_low[p] - own[p])
        if size == known and off <= _BEYOND:
            return changes
        known = size
        # What holds is held to the last digit before others are looked at.
        for i in range(count):
            row = held[i]
            own[row] -= own_high[row] if sides[row] > 0.0 else own_low[row]
        correction = np.empty(count)
        for i in range(count):
            correction[i] = own[held[i]]
        forward(factor, count, correction)
        backward(factor, count, correction)
        for i in range(count):
            row = held[i]
            multipliers[row] += correction[i]
            own[row] = own_high[row] if sides[row] > 0.0 else own_low[row]
        for p in range(size):
            if sides[p] != 1.0 and sides[p] != -1.0:
                for i in range(count):
                    own[p] -= pool.gram[p, held[i]] * correction[i]
        count, more = exchange(
            pool.gram, size, factor, held, sides, count,
            own, own_low, own_high, multipliers, most - changes,
        )  # fmt: skip
        if more < 0:
            return -1
        changes += more
    return -1
