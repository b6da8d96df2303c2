"""One QP of a level from beginning to end, as one compiled call."""

from __future__ import annotations

import numpy as np

from lexstack.compiled import compiled, entry
from lexstack.mpc.kernel.interior_point import interior
from lexstack.mpc.kernel.parts import add_cost, all_values, on_inputs, rolled
from lexstack.mpc.kernel.prepare import gathered
from lexstack.mpc.kernel.riccati import factor
from lexstack.mpc.kernel.schur import along, assemble, cholesky, row_values, solve
from lexstack.mpc.kernel.values import Array, Flags, Gains, Qp, Weights

UNSOLVED, FREE, INTERIOR = 0, 1, 2
_BEYOND = 1e-9  # m, rad, m/s ...: by how much an answer may exceed a bound


@compiled
def without_bounds(qp: Qp, motion: Array) -> bool:
    """Fill the least of the cost alone, with what it leads to, shape (3, N, n)."""
    stages, n = qp.gradient.shape
    gains = Gains(np.empty((3, stages, n)), np.empty((stages, n)))
    factor(qp.dt, qp.kappa, qp.weights, qp.fixed, gains)
    free = Qp(
        qp.dt, qp.kappa, qp.gradient, qp.weights, qp.rows[: qp.soft], qp.stages[: qp.soft],
        qp.wide[:0], qp.soft, qp.fixed, qp.low, qp.high, qp.lower[:0], qp.upper[:0],
    )  # fmt: skip
    matrix = np.empty((qp.soft, qp.soft))
    assemble(free, gains, np.ones(qp.soft), matrix)
    if not cholesky(matrix, qp.soft, 1e-15):
        return False
    force = np.zeros((3, stages, n))
    force[0] = -qp.gradient
    solve(free, gains, matrix, force, np.zeros(qp.soft), motion)
    return True


@compiled
def exceeded(qp: Qp, motion: Array) -> float:
    """Return by how much a bound is exceeded at most, in its own unit; nan where d is."""
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
            beyond = max(values[i] - qp.upper[i - hard], qp.lower[i - hard] - values[i])
        if not beyond <= worst:
            worst = beyond
    return worst


@entry(
    "int64(float64, Array(float64, 1, 'C', readonly=True), Array(float64, 2, 'C', readonly=True), "
    "Array(float64, 2, 'C', readonly=True), Array(float64, 3, 'C', readonly=True), "
    "Array(float64, 3, 'C', readonly=True), Array(float64, 1, 'C', readonly=True), "
    "Array(float64, 3, 'C', readonly=True), Array(float64, 3, 'C', readonly=True), "
    "Array(float64, 2, 'C', readonly=True), Array(float64, 3, 'C', readonly=True), "
    "Array(boolean, 2, 'C', readonly=True), float64[:, ::1], float64[:, ::1], float64[::1])"
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
        held: multipliers of the limits, shape (3 N + 1, n), to be filled.
        multipliers: of the bounded rows, shape (N r + w,), to be filled; 0 of those of one joint.
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
    held[:] = 0.0
    multipliers[:] = 0.0
    if not without_bounds(qp, motion):
        return UNSOLVED
    if exceeded(qp, motion) <= 0.0:
        direction[:] = motion[0]
        return FREE
    gain = max(1.5 * abs(along(qp.gradient, motion[0])), 1e-12)
    motion[:] = 0.0
    y = np.empty((3 * stages + 1) * n + qp.lower.size)
    if interior(qp, motion, y, gain) < 0:
        return UNSOLVED
    rolled(qp, motion[0].copy(), motion)
    if not exceeded(qp, motion) <= _BEYOND:
        return UNSOLVED
    direction[:] = motion[0]
    hard = held.size
    held[:] = y[:hard].reshape(held.shape)
    for i in range(places.size):
        if places[i] >= 0:
            multipliers[i] = y[hard + places[i]]
    for w in range(len(wide)):
        multipliers[places.size + w] = y[y.size - len(wide) + w]
    return INTERIOR
