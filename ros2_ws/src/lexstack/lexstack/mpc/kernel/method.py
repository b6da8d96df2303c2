"""One QP of a level from beginning to end, as one compiled call."""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled, entry
from lexstack.mpc.kernel.bounded import active, cost_alone
from lexstack.mpc.kernel.interior_point import interior
from lexstack.mpc.kernel.parts import add_cost, all_values, on_inputs, rolled
from lexstack.mpc.kernel.pool import Pool, begun, reduce
from lexstack.mpc.kernel.prepare import gathered
from lexstack.mpc.kernel.riccati import factor
from lexstack.mpc.kernel.schur import along, row_values, solve
from lexstack.mpc.kernel.values import Array, Flags, Gains, Qp, Weights

UNSOLVED, FREE, ACTIVE, INTERIOR = 0, 1, 2, 3
DENSE = 0.75  # of the inputs: with more rows in the cost, the condensed QP is as small
# that the active set method takes in, before the interior point method takes its place
LIMITS, LIMITS_PER_STAGE = 40, 4
# m, rad: of constraints, where the interior point method ends; its sums of large multipliers leave
# 1e-8 of rows that hardly differ, and the line search has delta
_ROOM = 2e-8
_BEYOND = 1e-9  # m, rad, m/s ...: by how much an answer may exceed a bound


@compiled
def least(qp: Qp, gains: Gains, pool: Pool, motion: Array) -> None:
    """Fill where the cost alone is least, with what it leads to, shape (3, N, n)."""
    force = np.zeros(motion.shape)
    force[0] = -qp.gradient
    solve(cost_alone(qp), gains, pool.joined, force, np.zeros(qp.soft), motion)


@compiled
def exceeded(qp: Qp, motion: Array, room: float) -> float:
    """Return by how much a bound is exceeded at most, in its own unit; nan where d is.

    Rows may be exceeded by ``room`` beside that, limits not.
    """
    stages, n = qp.gradient.shape
    hard = (3 * stages + 1) * n
    values = np.empty(hard + qp.lower.size)
    all_values(qp, motion, values)
    low, high = qp.low.reshape(-1), qp.high.reshape(-1)
    worst = 0.0
    for i in range(values.size):
        if i < hard:
            beyond = max(values[i] - high[i], low[i] - values[i])
        else:
            beyond = max(values[i] - qp.upper[i - hard], qp.lower[i - hard] - values[i]) - room
        if not beyond <= worst:
            worst = beyond
    return worst


@entry(
    "int64(float64, Array(float64, 1, 'C', readonly=True), Array(float64, 2, 'C', readonly=True), "
    "Array(float64, 2, 'C', readonly=True), Array(float64, 3, 'C', readonly=True), "
    "Array(float64, 3, 'C', readonly=True), Array(float64, 1, 'C', readonly=True), "
    "Array(float64, 3, 'C', readonly=True), Array(float64, 3, 'C', readonly=True), "
    "Array(float64, 2, 'C', readonly=True), Array(float64, 3, 'C', readonly=True), "
    "Array(boolean, 2, 'C', readonly=True), float64[:, ::1], float64[:, ::1], float64[::1], "
    "int64)"
)
def solve_level(
    dt: float,
    kappa: Array,
    gradient: Array,
    point: Array,
    coupled: Array,
    own: Array,
    change: Array,
    slopes: Array,
    wide: Array,
    bounds: Array,
    limits: Array,
    fixed: Flags,
    direction: Array,
    held: Array,
    multipliers: Array,
    most: int,
) -> int:
    """Solve min g.d + (d - p).H (d - p) / 2 within bounds; return how, or that it did not.

    Args:
        dt: s.
        kappa: of the last limit, shape (n,), s.
        gradient: g, shape (N, n).
        point: p, shape (N, n).
        coupled: Hessian by q of each state, shape (N, n, n).
        own: diagonals by u, v and q, shape (3, N, n).
        change: W of the effort, shape (n,).
        slopes: bounded rows of each state by its q, shape (N, r, n).
        wide: bounded rows by the q of all states, shape (w, N, n).
        bounds: lower and upper ones of these rows, shape (2, N r + w).
        limits: lower and upper ones of u, v, q and the last row, shape (2, 3 N + 1, n).
        fixed: inputs that stay, shape (N, n).
        direction: d, shape (N, n), to be filled.
        held: signs of the limits that probably hold, shape (3 N + 1, n); then their multipliers.
        multipliers: of the bounded rows likewise, shape (N r + w,); then 0 of those of one joint.
        most: changes of the active set, before the interior point method takes its place.
    """
    stages, n = gradient.shape
    slope, motion = gradient.copy(), np.empty((3, stages, n))
    weights = Weights(own[0], own[1], own[2], np.zeros(n), change)
    places = np.empty(stages * slopes.shape[1], dtype=np.int64)
    qp = gathered(dt, kappa, slope, coupled, weights, slopes, wide, bounds, limits, fixed, places)
    # -H p, where a point is to be near to.
    rolled(qp, point, motion)
    force = np.zeros((3, stages, n))
    rows = np.empty(len(qp.rows) + len(qp.wide))
    row_values(qp, motion[2], rows)
    add_cost(qp, motion, rows, -1.0, force)
    slope += on_inputs(qp, force)
    if qp.soft > DENSE * stages * n:
        return UNSOLVED
    gains = Gains(np.empty((3, stages, n)), np.empty((stages, n)))
    factor(qp.dt, qp.kappa, qp.weights, qp.fixed, gains)
    pool = begun(qp, gains, LIMITS + LIMITS_PER_STAGE * stages)
    if not reduce(qp, pool):
        return UNSOLVED
    least(qp, gains, pool, motion)
    over = exceeded(qp, motion, 0.0)
    if not math.isfinite(over):
        return UNSOLVED
    hard = held.size
    y = np.zeros(hard + qp.lower.size)
    if over > 0.0:
        y[:hard] = held.reshape(-1)
        for i in range(places.size):
            if places[i] >= 0:
                y[hard + places[i]] = multipliers[i]
        for w in range(len(wide)):
            y[y.size - len(wide) + w] = multipliers[places.size + w]
        gain = max(1.5 * abs(along(qp.gradient, motion[0])), 1e-12)
    how = FREE
    if over > 0.0:
        how = ACTIVE
        found = active(qp, gains, pool, motion, y, most) >= 0
        rolled(qp, motion[0].copy(), motion)
        if not (found and exceeded(qp, motion, 0.0) <= _BEYOND):
            how = INTERIOR
            motion[:] = 0.0
            found = interior(qp, motion, y, gain) >= 0
            rolled(qp, motion[0].copy(), motion)
            if not (found and exceeded(qp, motion, _ROOM) <= _BEYOND):
                held[:] = 0.0
                multipliers[:] = 0.0
                return UNSOLVED
    direction[:] = motion[0]
    held[:] = y[:hard].reshape(held.shape)
    multipliers[:] = 0.0
    for i in range(places.size):
        if places[i] >= 0:
            multipliers[i] = y[hard + places[i]]
    for w in range(len(wide)):
        multipliers[places.size + w] = y[y.size - len(wide) + w]
    return how
