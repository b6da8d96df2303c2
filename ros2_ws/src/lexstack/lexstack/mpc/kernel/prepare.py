"""From a level's Hessian and bounds by stages to the rows and limits of one ``Qp``."""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.values import Array, Flags, Places, Qp, Weights

_DEPENDENT = 1e-13  # of the largest pivot: what rounding leaves of a stage's stiffness
_POINT = 1e-7  # m or rad: bounds that are closer hold as an equation
_ROUNDING = 1e-9  # m/s^2 or rad/s^2
_NO_CHOICE = 1e-7  # m/s^2 or rad/s^2: an input with less room keeps its value


@compiled
def split(coupled: Array, positions: Array, rows: Array, stages: Places) -> int:
    """Split the stiffness of each stage into rows r, sum r r', and what is a joint's own.

    Args:
        coupled: the Hessian by q of each state, shape (N, n, n), positive semi-definite.
        positions: the joints' own, shape (N, n); what is diagonal is added to it.
        rows: the rows, shape (N n or more, n): of a pivoted Cholesky factor.
        stages: the state of each row, likewise.

    Returns:
        How many rows there are.
    """
    count = 0
    number, n, _ = coupled.shape
    rest = np.empty((n, n))
    for k in range(number):
        largest = 0.0
        for i in range(n):
            alone = True
            for j in range(n):
                rest[i, j] = coupled[k, i, j]
                if j != i and rest[i, j] != 0.0:
                    alone = False
            if alone:
                positions[k, i] += rest[i, i]
                rest[i, i] = 0.0
            largest = max(largest, rest[i, i])
        for _ in range(n):
            pivot = 0
            for i in range(1, n):
                if rest[i, i] > rest[pivot, pivot]:
                    pivot = i
            if not rest[pivot, pivot] > _DEPENDENT * largest:
                break
            scale = 1.0 / math.sqrt(rest[pivot, pivot])
            for j in range(n):
                rows[count, j] = scale * rest[pivot, j]
            for i in range(n):
                for j in range(n):
                    rest[i, j] -= rows[count, i] * rows[count, j]
            for j in range(n):
                rest[pivot, j] = 0.0
                rest[j, pivot] = 0.0
            stages[count] = k
            count += 1
    return count


@compiled
def place_bounds(
    slopes: Array, lower: Array, upper: Array, low: Array, high: Array, places: Places
) -> int:
    """Find the rows that couple joints, or have no room; those of one joint narrow its limits.

    Args:
        slopes: bounded rows of each state, shape (N, r, n).
        lower: their bounds, shape (N r,), with 0 between them.
        upper: likewise.
        low: of all limits, shape (3 N + 1, n).
        high: likewise.
        places: of each row: how many before it are coupled; or -1 - joint for those of one joint,
            or -1 - n for those of none; shape (N r,).

    Returns:
        How many rows couple joints.
    """
    stages, count, n = slopes.shape
    coupled = 0
    for k in range(stages):
        for r in range(count):
            only, several = n, False
            for j in range(n):
                if slopes[k, r, j] != 0.0:
                    several = only < n
                    only = j
                    if several:
                        break
            i = k * count + r
            if several or (only < n and upper[i] - lower[i] < _POINT):
                places[i] = coupled
                coupled += 1
                continue
            places[i] = -1 - only
            if only < n:
                slope = slopes[k, r, only]
                first, second = lower[i] / slope, upper[i] / slope
                row = 2 * stages + k
                low[row, only] = max(low[row, only], min(first, second))
                high[row, only] = min(high[row, only], max(first, second))
    return coupled


@compiled
def pin(dt: float, low: Array, high: Array, fixed: Flags) -> None:
    """Fix the first inputs of a joint that its limits leave no choice, at the present value.

    A measured state beyond a limit is met by the hardest braking alone. Such limits have no
    inside; with the inputs fixed, those of their stages have nothing more to say.
    """
    stages, n = fixed.shape
    half = 0.5 * dt * dt
    for j in range(n):
        if fixed[0, j]:
            low[:, j] = -math.inf
            high[:, j] = math.inf
            continue
        for k in range(stages):
            least = max(low[k, j], low[stages + k, j] / dt, low[2 * stages + k, j] / half)
            most = min(high[k, j], high[stages + k, j] / dt, high[2 * stages + k, j] / half)
            if most - least > _NO_CHOICE or least > _ROUNDING or most < -_ROUNDING:
                break
            fixed[k, j] = True
            for row in (k, stages + k, 2 * stages + k):
                low[row, j] = -math.inf
                high[row, j] = math.inf


@compiled
def gathered(
    dt: float,
    kappa: Array,
    gradient: Array,
    coupled: Array,
    weights: Weights,
    slopes: Array,
    wide: Array,
    bounds: Array,
    limits: Array,
    fixed: Flags,
    places: Places,
) -> Qp:
    """Return the QP of a level; see ``solver.solve``, whose arguments these are."""
    stages, n = gradient.shape
    positions, low, high = weights.positions.copy(), limits[0].copy(), limits[1].copy()
    pinned = fixed.copy()
    count, number = slopes.shape[1], stages * slopes.shape[1]
    lower, upper = bounds[0, :number], bounds[1, :number]
    joined = place_bounds(slopes, lower, upper, low, high, places)
    rows = np.zeros((stages * n + joined, n))
    at = np.zeros(stages * n + joined, dtype=np.int64)
    soft = split(coupled, positions, rows, at)
    least, most = np.empty(joined + len(wide)), np.empty(joined + len(wide))
    for i in range(number):
        if places[i] >= 0:
            row = soft + places[i]
            rows[row] = slopes[i // count, i % count]
            at[row] = i // count
            least[places[i]], most[places[i]] = lower[i], upper[i]
    least[joined:], most[joined:] = bounds[0, number:], bounds[1, number:]
    pin(dt, low, high, pinned)
    own = Weights(weights.inputs, weights.velocities, positions, np.zeros(n), weights.change)
    size = soft + joined
    return Qp(
        dt, kappa, gradient, own, rows[:size], at[:size], wide, soft, pinned, low, high, least, most
    )
