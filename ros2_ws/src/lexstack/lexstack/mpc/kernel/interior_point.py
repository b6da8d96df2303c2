"""Mehrotra's interior point method on a QP by its structure; at most ``MOST`` factorisations.

Every bound has a slack s and a multiplier z. Newton's step on the optimality conditions adds the
weight z / s to each limit, which is the joint's own, so that ``riccati`` takes it, and to each
bounded row, whose 1 / weight enters the diagonal of ``schur``. With the residuals p of a slack and
c of s z,

    ds = p - a.dd,    dz = -(c + z ds) / s,    so    dy = (z / s) a.dd - t,    t = (c + z p) / s

for an upper bound, and the mirror image for a lower one, y = z_upper - z_lower. A row's a.dd comes
from its multiplier step, (dy + t) s / z: that of the motion would lose all digits where s is small.
Primal residuals shrink by 1 - alpha exactly; they are carried along and not measured.

Rows whose bounds are one point have no slack: their multiplier is found by the proximal method of
multipliers, a.d - b = 1e-9 dy.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.parts import (
    add_limits,
    all_values,
    limit_values,
    steepness,
    value,
    weighted,
)
from lexstack.mpc.kernel.riccati import factor
from lexstack.mpc.kernel.schur import assemble, cholesky, solve
from lexstack.mpc.kernel.values import Array, Flags, Gains, Qp

MOST = 30
_POINT = 1e-7
_PROXIMAL = 1e-9
_WIDE = 4e-10  # m, rad ...: on both sides of what has no room
_GAP, _LEAST = 1e-9, 1e-12  # of the cost, and in its unit: the duality gap at the end
_SLOPE = 0.1  # of this gap's size may be what the slope that is left promises
_BEYOND = 1e-10  # by how much a bound may be exceeded


@compiled
def keep_active(s: Array, z: Array, is_point: Flags, y: Array) -> None:
    """Make the multipliers 0 of what does not hold, shape (M,): where no z exceeds its s."""
    for i in range(y.size):
        if not is_point[i] and not max(z[0, i] - s[0, i], z[1, i] - s[1, i]) > 0.0:
            y[i] = 0.0


@compiled
def interior(qp: Qp, motion: Array, y: Array, gain: float) -> int:
    """Solve the QP; ``motion`` (3, N, n) is where it begins and its solution, y its multipliers.

    Args:
        qp: the QP.
        motion: d with the velocities and positions that it leads to.
        y: shape (M,): of the limits, then of the bounded rows.
        gain: an estimate of what the cost may fall by, > 0.

    Returns:
        How many factorisations it took, or -1 where it did not come to an end.
    """
    stages, n = qp.gradient.shape
    hard = (3 * stages + 1) * n
    size = qp.rows.shape[0] + len(qp.wide)
    bounds = hard + size - qp.soft
    low, high = np.empty(bounds), np.empty(bounds)
    low[:hard], high[:hard] = qp.low.reshape(-1), qp.high.reshape(-1)
    low[hard:], high[hard:] = qp.lower, qp.upper
    values = np.empty(bounds)
    all_values(qp, motion, values)
    s, z, p = np.ones((2, bounds)), np.zeros((2, bounds)), np.zeros((2, bounds))
    is_point = np.zeros(bounds, dtype=np.bool_)
    y[:] = 0.0
    count = 0
    for i in range(bounds):
        if i >= hard and high[i] - low[i] < _POINT:
            is_point[i] = True
            low[i] = high[i] = 0.5 * (low[i] + high[i])
            continue
        if high[i] - low[i] < 2.0 * _WIDE:
            low[i] -= _WIDE
            high[i] += _WIDE
        room = high[i] - low[i]
        least = min(1.0, 0.5 * room)
        for side in range(2):
            bound = high[i] if side == 0 else low[i]
            if math.isfinite(bound):
                left = bound - values[i] if side == 0 else values[i] - bound
                s[side, i] = max(left, least)
                z[side, i] = 1.0
                p[side, i] = left - s[side, i]
                count += 1
    force, step = np.empty((3, stages, n)), np.empty((3, stages, n))
    # First multipliers: of equal products, which together are what the cost may fall by.
    start = gain / max(count, 1)
    for side in range(2):
        for i in range(bounds):
            if z[side, i] > 0.0:
                z[side, i] = start / s[side, i]
    gains = Gains(np.empty((3, stages, n)), np.empty((stages, n)))
    matrix = np.empty((size, size))
    inverse, right = np.ones(size), np.empty(size)
    sigma, t, by_row = np.zeros(bounds), np.zeros(bounds), np.empty(bounds)
    c = np.zeros((2, bounds))
    ds, dz = np.zeros((2, bounds)), np.zeros((2, bounds))
    np.zeros(size)
    # The nearest to an end so far: rounding may lead away from it again.
    least, best, best_y = math.inf, np.empty((3, stages, n)), np.empty(bounds)
    for turn in range(MOST):
        gap, worst = 0.0, 0.0
        for i in range(bounds):
            if is_point[i]:
                worst = max(worst, abs(low[i] - values[i]))
                continue
            y[i] = z[0, i] - z[1, i]
            for side in range(2):
                if z[side, i] > 0.0:
                    gap += s[side, i] * z[side, i]
                    worst = max(worst, abs(p[side, i]))
        steep = steepness(qp, motion, y, force)
        cost, size_of = value(qp, motion), float(np.abs(motion[0]).sum())
        loose = max(_GAP * abs(cost), _LEAST)
        error = max(gap, _SLOPE * steep * size_of)
        if turn > 0 and worst <= _BEYOND and error <= loose:
            keep_active(s, z, is_point, y)
            return turn
        if turn > 0 and worst <= 1e-9 and error <= min(least, 1e2 * loose):
            least = error
            best[:] = motion
            best_y[:] = y
            keep_active(s, z, is_point, best_y)
        mu = gap / max(count, 1)
        for i in range(bounds):
            if not is_point[i]:
                sigma[i] = z[0, i] / s[0, i] + z[1, i] / s[1, i]
            if i >= hard:
                place = qp.soft + i - hard
                inverse[place] = _PROXIMAL if is_point[i] else 1.0 / sigma[i]
        own = weighted(qp, sigma[:hard].reshape(3 * stages + 1, n))
        factor(qp.dt, qp.kappa, own, qp.fixed, gains)
        assemble(qp, gains, inverse, matrix)
        if not cholesky(matrix, size, 1e-15):
            break
        for side in range(2):
            for i in range(bounds):
                c[side, i] = s[side, i] * z[side, i]
        for corrected in range(2):
            for i in range(bounds):
                if is_point[i]:
                    right[qp.soft + i - hard] = low[i] - values[i]
                    continue
                t[i] = (c[0, i] + z[0, i] * p[0, i]) / s[0, i]
                t[i] -= (c[1, i] + z[1, i] * p[1, i]) / s[1, i]
                if i >= hard:
                    right[qp.soft + i - hard] = t[i] / sigma[i]
            right[: qp.soft] = 0.0
            steepness(qp, motion, y, force)
            add_limits(qp, t[:hard].reshape(3 * stages + 1, n), 1.0, force)
            solve(qp, gains, matrix, force, right, step)
            limit_values(qp, step, by_row[:hard].reshape(3 * stages + 1, n))
            alpha = 1.0
            for i in range(bounds):
                if is_point[i]:
                    continue
                if i >= hard:
                    by_row[i] = (right[qp.soft + i - hard] + t[i]) / sigma[i]
                for side in range(2):
                    if z[side, i] > 0.0:
                        change = by_row[i] if side == 0 else -by_row[i]
                        ds[side, i] = p[side, i] - change
                        dz[side, i] = -(c[side, i] + z[side, i] * ds[side, i]) / s[side, i]
                        if ds[side, i] < 0.0:
                            alpha = min(alpha, -s[side, i] / ds[side, i])
                        if dz[side, i] < 0.0:
                            alpha = min(alpha, -z[side, i] / dz[side, i])
            if corrected == 0:
                left = 0.0
                for side in range(2):
                    for i in range(bounds):
                        if z[side, i] > 0.0:
                            left += (s[side, i] + alpha * ds[side, i]) * (
                                z[side, i] + alpha * dz[side, i]
                            )
                ratio = left / max(gap, 1e-300)
                target = mu * ratio * ratio * ratio
                for side in range(2):
                    for i in range(bounds):
                        if z[side, i] > 0.0:
                            c[side, i] += ds[side, i] * dz[side, i] - target
        if alpha < 1.0:
            alpha *= max(0.99, 1.0 - mu)
        if not alpha >= 1e-6:
            break
        for i in range(3):
            for k in range(stages):
                for j in range(n):
                    motion[i, k, j] += alpha * step[i, k, j]
        for i in range(bounds):
            if is_point[i]:
                y[i] += alpha * right[qp.soft + i - hard]
                values[i] += alpha * (low[i] - values[i] + _PROXIMAL * right[qp.soft + i - hard])
                continue
            values[i] += alpha * by_row[i]
            for side in range(2):
                if z[side, i] > 0.0:
                    s[side, i] += alpha * ds[side, i]
                    z[side, i] += alpha * dz[side, i]
                    p[side, i] *= 1.0 - alpha
    if not math.isfinite(least):
        return -1
    motion[:] = best
    y[:] = best_y
    return MOST
