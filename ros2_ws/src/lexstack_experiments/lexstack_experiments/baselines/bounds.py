"""The boxes on chi that paper T prints, T(31) and T(34): they can be empty, and are counted."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass
class EmptyBoxes:
    """Counts boxes that hold nothing.

    Attributes:
        boxes: how many were counted, one per tick.
        empty: how many of them no chi fits in.
        joints: empty intervals in all of them.
    """

    boxes: int = 0
    empty: int = 0
    joints: int = 0

    def count(self, bounds: Bounds) -> Bounds:
        """Count a box and return it as it is."""
        joints = bounds.empty
        self.boxes += 1
        self.empty += joints > 0
        self.joints += joints
        return bounds

    def repaired(self, bounds: Bounds) -> Bounds:
        """Count a box and return it with each empty interval replaced by its middle.

        No solver can serve an empty box; an experiment that wants to go on serves this one.
        """
        return self.replaced(bounds, 0.5 * (bounds.lower + bounds.upper))

    def replaced(self, bounds: Bounds, chi: Vector) -> Bounds:
        """Count a box and return it with each empty interval replaced by what ``chi`` (n,) says."""
        self.count(bounds)
        empty = bounds.lower > bounds.upper
        return Bounds(np.where(empty, chi, bounds.lower), np.where(empty, chi, bounds.upper))
