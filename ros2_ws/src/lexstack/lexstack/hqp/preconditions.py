"""What every solver looks at: whether a problem can be solved at all, and which bounds hold."""

from __future__ import annotations

import math

import numpy as np

from lexstack.errors import InputError
from lexstack.hqp.hierarchy import FEASIBILITY, Hierarchy, Signs
from lexstack.hqp.problem import HqpProblem, called
from lexstack.limits.joint_limits import Bounds
from lexstack.types import Vector


def starting_point(hierarchy: Hierarchy, problem: HqpProblem) -> tuple[Vector, str]:
    """Return the point of the bounds next to zero, and why the problem is unusable, if it is.

    Args:
        hierarchy: of the problem's levels.
        problem: with its bounds.

    Raises:
        InputError: the ends of the bounds do not fit each other (a programming error).
    """
    lower, upper = problem.bounds.lower, problem.bounds.upper
    if lower.shape != upper.shape or lower.ndim != 1:
        raise InputError(f"bounds: lower {lower.shape} and upper {upper.shape} do not fit chi")
    chi = np.minimum(np.maximum(lower, 0.0), upper)
    ordered = lower <= upper
    if np.count_nonzero(ordered) < chi.size or not math.isfinite(chi.dot(chi)):
        usable = ordered & np.isfinite(chi)
        joint = int(np.argmin(usable))
        reason = f"bounds: joint {joint}: [{lower[joint]}, {upper[joint]}] holds no number"
        return np.where(usable, chi, 0.0), reason
    residual = hierarchy.lower if hierarchy.exact else hierarchy.residual(chi)
    norms = sum([level.norm for level in hierarchy.levels])
    if not math.isfinite(norms + residual.dot(residual)):
        slacks = hierarchy.slacks(residual)
        sizes = [slack + level.norm for slack, level in zip(slacks, hierarchy.levels, strict=True)]
        k = next((k for k, size in enumerate(sizes) if not math.isfinite(size)), 0)
        which = called(k, problem.levels[k])
        return chi, f"{which}: a task holds a number that is not finite, or too large"
    if not hierarchy.exact:
        for k, level in enumerate(hierarchy.levels):
            if not (level.lower <= level.upper).all():
                which = called(k, problem.levels[k])
                return chi, f"{which}: a task has a row whose lower end is above its upper end"
    return chi, ""


def active_bounds(chi: Vector, bounds: Bounds) -> Signs:
    """Return -1 where chi is at its lower bound, +1 where it is at its upper bound, or both.

    Up to rounding: it is the next solve's first guess.
    """
    above, below = bounds.upper - chi, chi - bounds.lower
    room = np.minimum(above, below)
    sides: Signs = np.zeros(chi.size, dtype=np.int8)
    if room.size and room[room.argmin()] <= FEASIBILITY:
        sides[below <= FEASIBILITY] = -1
        sides[above <= FEASIBILITY] = 1
    return sides
