"""The boxes on chi that paper T prints, T(31) and T(34): they can be empty."""

from __future__ import annotations

import numpy as np

from lexstack.limits import Bounds, JointLimits
from lexstack.types import Vector


def t31(position: Vector, limits: JointLimits, dt: float, applied: Vector) -> Bounds:
    """Return T(31), three boxes intersected; lower may be above upper.

        q_min <= q + chi dt <= q_max,  -v_max <= chi <= v_max,  |chi - chi(t - dt)| <= a_max dt

    Args:
        position: q*, shape (n,), m and rad.
        limits: of all robots.
        dt: control period [s].
        applied: chi(t - dt), shape (n,), m/s and rad/s.
    """
    reach = limits.acceleration * dt
    lower = np.maximum((limits.position_lower - position) / dt, -limits.velocity)
    upper = np.minimum((limits.position_upper - position) / dt, limits.velocity)
    return Bounds(np.maximum(lower, applied - reach), np.minimum(upper, applied + reach))


def t34(before: Bounds, new: Bounds, part: float) -> Bounds:
    """Return T(34), the box between two: alpha new + (1 - alpha) before.

    The paper leaves open what chi_min(t - dt) is in a loop. Two readings make sense: the box of
    the old limits at this tick, or the box that was in effect at the tick before, blended itself.

    Args:
        before: chi_min, chi_max (t - dt).
        new: chi_min^s, chi_max^s: T(31) with the new limits.
        part: alpha of the transition, in [0, 1].
    """
    rest = 1.0 - part
    return Bounds(part * new.lower + rest * before.lower, part * new.upper + rest * before.upper)


def replaced(bounds: Bounds, chi: Vector) -> Bounds:
    """Return a box with each empty interval replaced by what ``chi`` (n,) says.

    No solver can serve an empty box; an experiment that wants to go on serves this one.
    """
    empty = bounds.lower > bounds.upper
    return Bounds(np.where(empty, chi, bounds.lower), np.where(empty, chi, bounds.upper))
