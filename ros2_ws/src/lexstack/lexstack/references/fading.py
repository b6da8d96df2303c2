"""A gap between two references that fades to zero: the quintic that ends at rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from lexstack.references.spaces import Space
from lexstack.types import Vector

T = TypeVar("T")

_STEP = 1e-3  # s, for differences: its square is the relative error of a rate


@dataclass(frozen=True, slots=True, eq=False)
class Fading:
    """A gap that fades to zero, at rest in the end.

    Attributes:
        start: simulated time at which it began [s].
        duration: T [s], positive.
        gap: at the start, shape (m,): m, then rad.
        rate: its derivative there, shape (m,), m/s and rad/s.
        curvature: its second derivative there, shape (m,), m/s^2 and rad/s^2.
    """

    start: float
    duration: float
    gap: Vector
    rate: Vector
    curvature: Vector

    def over(self, stamp: float) -> bool:
        """Return whether the gap is zero at a time [s]."""
        return stamp - self.start >= self.duration

    def at(self, stamp: float) -> Vector:
        """Return the gap at a time [s], shape (m,)."""
        s = min((stamp - self.start) / self.duration, 1.0)
        rest = (1.0 - s) ** 3
        by_gap = rest * (1.0 + s * (3.0 + 6.0 * s))  # 1 - a(s)
        by_rate = self.duration * s * rest * (1.0 + 3.0 * s)
        by_curvature = self.duration**2 * 0.5 * s * s * rest
        return by_gap * self.gap + by_rate * self.rate + by_curvature * self.curvature

    def rate_at(self, stamp: float) -> Vector:
        """Return the derivative of ``at`` at a time [s], shape (m,), m/s and rad/s."""
        s = min((stamp - self.start) / self.duration, 1.0)
        rest = (1.0 - s) ** 2
        by_gap = -30.0 * s * s * rest / self.duration
        by_rate = rest * (1.0 + s * (2.0 - 15.0 * s))
        by_curvature = self.duration * rest * s * (1.0 - 2.5 * s)
        return by_gap * self.gap + by_rate * self.rate + by_curvature * self.curvature


def faded(
    gap_at: Callable[[float], Vector],
    stamp: float,
    duration: float,
    space: Space[T],
    *,
    still: bool = False,
) -> Fading:
    """Return the way on which a gap fades that moves until now, without a jump in its motion.

    Args:
        gap_at: the gap at times just before and after the start.
        stamp: time of the start [s].
        duration: of the way [s], positive.
        space: whose gaps they are.
        still: whether the gap is known to rest.
    """
    gap = gap_at(stamp)
    if still:
        zeros = np.zeros_like(gap)
        return Fading(stamp, duration, gap, zeros, zeros)
    before, after = (space.nearest(gap_at(stamp + step), gap) for step in (-_STEP, _STEP))
    rate = (after - before) / (2.0 * _STEP)
    curvature = (after - 2.0 * gap + before) / _STEP**2
    return Fading(stamp, duration, gap, rate, curvature)
