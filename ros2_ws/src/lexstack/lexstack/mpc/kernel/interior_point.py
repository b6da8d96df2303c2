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
from typing import NamedTuple

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
_POINT = 1e-7  # m, rad: rows whose bounds are closer are held at one point
_PROXIMAL = 1e-9
_WIDE = 4e-10  # m, rad ...: on both sides of a limit that has no room
_GAP, _LEAST = 1e-9, 1e-12  # of the cost, and in its unit: the duality gap at the end
_SLOPE = 0.1  # of this gap's size may be what the slope that is left promises
_BEYOND, _PASSABLE = 1e-10, 1e-9  # by how much a bound may be exceeded: at the end, and at worst
_ENOUGH = 1e2  # so many times the gap is passable, where no iteration comes to the end


class Bounds(NamedTuple):
    """All bounds, limits first, and what the method keeps of each: shapes (M,) and (2, M).

    Attributes:
        low: lower bounds.
        high: upper bounds.
        values: what they are on.
        s: slacks, upper bounds first.
        z: multipliers, 0 for ever where a bound is infinite.
        p: what a slack is smaller than it should be.
        is_point: rows that are held.
    """

    low: Array
    high: Array
    values: Array
    s: Array
    z: Array
    p: Array
    is_point: Flags


class Newton(NamedTuple):
    """One factorisation and the steps that it gives: weights, t, a.dd, ds, dz; y of the rows."""

    weights: Array
    t: Array
    along: Array
    ds: Array
    dz: Array
    inverse: Array
    right: Array
    matrix: Array
    gains: Gains
    force: Array
    motion: Array


@compiled
def started(qp: Qp, motion: Array, gain: float) -> Bounds:
    """Return slacks of about the room there is, and multipliers so that all s z are equal."""
    hard = qp.low.size
    count = hard + qp.lower.size
    low = np.concatenate((qp.low.copy().reshape(-1), qp.lower))
    high = np.concatenate((qp.high.copy().reshape(-1), qp.upper))
    values = np.empty(count)
    all_values(qp, motion, values)
    s, z, p = np.ones((2, count)), np.zeros((2, count)), np.zeros((2, count))
    is_point = np.zeros(count, dtype=np.bool_)
    sides = 0
    for i in range(count):
        if i >= hard and high[i] - low[i] < _POINT:
            is_point[i] = True
            low[i] = high[i] = 0.5 * (low[i] + high[i])
            continue
        if high[i] - low[i] < 2.0 * _WIDE:
            low[i] -= _WIDE
            high[i] += _WIDE
        least = min(1.0, 0.5 * (high[i] - low[i]))
        for side in range(2):
            if math.isfinite(high[i] if side == 0 else low[i]):
                room = high[i] - values[i] if side == 0 else values[i] - low[i]
                s[side, i] = max(room, least)
                z[side, i] = 1.0 / s[side, i]
                p[side, i] = room - s[side, i]
                sides += 1
    z *= gain / max(sides, 1)
    return Bounds(low, high, values, s, z, p, is_point)


@compiled
def allocated(qp: Qp, count: int) -> Newton:
    """Return space for ``count`` bounds."""
    stages, n = qp.gradient.shape
    size = qp.soft + qp.lower.size
    gains = Gains(np.empty((3, stages, n)), np.empty((stages, n)))
    return Newton(
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros((2, count)),
        np.zeros((2, count)),
        np.ones(size),
        np.zeros(size),
        np.empty((size, size)),
        gains,
        np.empty((3, stages, n)),
        np.empty((3, stages, n)),
    )


@compiled
def factored(qp: Qp, bounds: Bounds, newton: Newton) -> bool:
    """Factor with the weights z / s of all bounds; False: rounding left no factor."""
    hard = qp.low.size
    s, z, weights = bounds.s, bounds.z, newton.weights
    for i in range(weights.size):
        if not bounds.is_point[i]:
            weights[i] = z[0, i] / s[0, i] + z[1, i] / s[1, i]
        if i >= hard:
            inverse = _PROXIMAL if bounds.is_point[i] else 1.0 / weights[i]
            newton.inverse[qp.soft + i - hard] = inverse
    own = weighted(qp, weights[:hard].reshape(qp.low.shape))
    factor(qp.dt, qp.kappa, own, qp.fixed, newton.gains)
    assemble(qp, newton.gains, newton.inverse, newton.matrix)
    return cholesky(newton.matrix, newton.right.size, 1e-15)


@compiled
def stepped(qp: Qp, bounds: Bounds, motion: Array, y: Array, c: Array, newton: Newton) -> float:
    """Fill the Newton step for residuals c of s z; return which part of it keeps s and z > 0."""
    hard = qp.low.size
    s, z, p, t, right = bounds.s, bounds.z, bounds.p, newton.t, newton.right
    right[: qp.soft] = 0.0
    for i in range(t.size):
        row = qp.soft + i - hard
        if bounds.is_point[i]:
            right[row] = bounds.low[i] - bounds.values[i]
            continue
        t[i] = (c[0, i] + z[0, i] * p[0, i]) / s[0, i]
        t[i] -= (c[1, i] + z[1, i] * p[1, i]) / s[1, i]
        if i >= hard:
            right[row] = t[i] / newton.weights[i]
    steepness(qp, motion, y, newton.force)
    add_limits(qp, t[:hard].reshape(qp.low.shape), 1.0, newton.force)
    solve(qp, newton.gains, newton.matrix, newton.force, right, newton.motion)
    limit_values(qp, newton.motion, newton.along[:hard].reshape(qp.low.shape))
    alpha = 1.0
    for i in range(t.size):
        if bounds.is_point[i]:
            continue
        if i >= hard:
            newton.along[i] = (right[qp.soft + i - hard] + t[i]) / newton.weights[i]
        for side in range(2):
            if z[side, i] > 0.0:
                change = newton.along[i] if side == 0 else -newton.along[i]
                ds = p[side, i] - change
                dz = -(c[side, i] + z[side, i] * ds) / s[side, i]
                if ds < 0.0:
                    alpha = min(alpha, -s[side, i] / ds)
                if dz < 0.0:
                    alpha = min(alpha, -z[side, i] / dz)
                newton.ds[side, i], newton.dz[side, i] = ds, dz
    return alpha


@compiled
def corrected(bounds: Bounds, newton: Newton, alpha: float, gap: float, c: Array) -> None:
    """Add the second-order error of the first step to c, and centre: Mehrotra's corrector."""
    s, z, ds, dz = bounds.s, bounds.z, newton.ds, newton.dz
    left, sides = 0.0, 0
    for side in range(2):
        for i in range(newton.t.size):
            if z[side, i] > 0.0:
                sides += 1
                left += (s[side, i] + alpha * ds[side, i]) * (z[side, i] + alpha * dz[side, i])
    ratio = left / max(gap, 1e-300)
    target = gap / max(sides, 1) * ratio * ratio * ratio
    for side in range(2):
        for i in range(newton.t.size):
            if z[side, i] > 0.0:
                c[side, i] += ds[side, i] * dz[side, i] - target


@compiled
def advanced(qp: Qp, bounds: Bounds, motion: Array, y: Array, newton: Newton, alpha: float) -> None:
    """Go a part of the step."""
    hard = qp.low.size
    for i in range(3):
        for k in range(motion.shape[1]):
            for j in range(motion.shape[2]):
                motion[i, k, j] += alpha * newton.motion[i, k, j]
    for i in range(y.size):
        if bounds.is_point[i]:
            change = newton.right[qp.soft + i - hard]
            y[i] += alpha * change
            off = bounds.low[i] - bounds.values[i]
            bounds.values[i] += alpha * (off + _PROXIMAL * change)
            continue
        bounds.values[i] += alpha * newton.along[i]
        for side in range(2):
            if bounds.z[side, i] > 0.0:
                bounds.s[side, i] += alpha * newton.ds[side, i]
                bounds.z[side, i] += alpha * newton.dz[side, i]
                bounds.p[side, i] *= 1.0 - alpha


@compiled
def measured(bounds: Bounds, y: Array) -> tuple[float, float]:
    """Fill y; return the duality gap, and by how much a bound may be exceeded at most."""
    gap, worst = 0.0, 0.0
    for i in range(y.size):
        if bounds.is_point[i]:
            worst = max(worst, abs(bounds.low[i] - bounds.values[i]))
            continue
        y[i] = bounds.z[0, i] - bounds.z[1, i]
        for side in range(2):
            if bounds.z[side, i] > 0.0:
                gap += bounds.s[side, i] * bounds.z[side, i]
                worst = max(worst, abs(bounds.p[side, i]))
    return gap, worst


@compiled
def keep_active(bounds: Bounds, y: Array) -> None:
    """Make the multipliers 0 of what does not hold, shape (M,): where no z exceeds its s."""
    s, z = bounds.s, bounds.z
    for i in range(y.size):
        if not bounds.is_point[i] and not max(z[0, i] - s[0, i], z[1, i] - s[1, i]) > 0.0:
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
    bounds = started(qp, motion, gain)
    newton = allocated(qp, y.size)
    y[:] = 0.0
    # The nearest to an end so far: rounding may lead away from it again.
    least, best, best_y = math.inf, np.empty(motion.shape), np.empty(y.size)
    for turn in range(MOST):
        gap, worst = measured(bounds, y)
        steep = steepness(qp, motion, y, newton.force)
        loose = max(_GAP * abs(value(qp, motion)), _LEAST)
        error = max(gap, _SLOPE * steep * float(np.abs(motion[0]).sum()))
        if turn > 0 and worst <= _PASSABLE and error <= min(least, _ENOUGH * loose):
            least = error
            best[:] = motion
            best_y[:] = y
            keep_active(bounds, best_y)
            if worst <= _BEYOND and error <= loose:
                break
        if not factored(qp, bounds, newton):
            break
        c = bounds.s * bounds.z
        alpha = stepped(qp, bounds, motion, y, c, newton)
        corrected(bounds, newton, alpha, gap, c)
        alpha = stepped(qp, bounds, motion, y, c, newton)
        if alpha < 1.0:
            alpha *= 0.995
        if not alpha >= 1e-6:
            break
        advanced(qp, bounds, motion, y, newton, alpha)
    if not math.isfinite(least):
        return -1
    motion[:] = best
    y[:] = best_y
    return turn
