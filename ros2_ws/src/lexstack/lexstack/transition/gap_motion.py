"""What a new gap keeps of the motion at its latch, so that the acceleration does not jump.

A gap that is latched while the command accelerates would begin to fade from rest: the acceleration
would jump. The gap d(t) = chi_A - chi_S therefore begins with what is known of its motion, and the
quintics H_1, H_2 lead its rate and its second derivative to zero in the time T of the blend:

    d(t) = (1 - alpha) delta + T H_1(t/T) d'(t0) + T^2 H_2(t/T) d''(t0) + tau H_1(t/tau) mismatch
    H_1(s) = s - 6 s^3 + 8 s^4 - 3 s^5          H_2(s) = (s^2 - 3 s^3 + 3 s^4 - s^5) / 2

d' and d'' are those of the gap that was fading before. mismatch is what is left of the difference
of the accelerations of the command and of the source; it shows one tick after the latch, and as it
is a difference of two messages it is faded out in a short time tau. A mismatch that still fades
when the next gap is latched goes on to fade beside it, in its own time: as a part of d' and d'' its
curvature of tau would be faded out in T, and drive the command far off, farther with every latch.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lexstack.transition.robot_group import Columns
from lexstack.transition.tick_context import TickContext
from lexstack.types import Vector

Mismatch = tuple[Vector, float, float]
"""A mismatch of a latch before, shape (n,), the time since that latch [s], and its tau [s]."""

_SHORT = 0.2  # s, tau; a jump of the source by x makes an excursion of about 4 x at 100 Hz
_JUMP = 5.0  # of a joint's acceleration limit: more is no acceleration, but a jump of the source
_FELT = 1e-3  # of a joint's acceleration limit: a smaller difference of accelerations is ignored


@dataclass(frozen=True, slots=True, eq=False)
class GapMotion:
    """The motion of a gap at its latch, shape (n,) each.

    Attributes:
        rate: d', m/s^2 and rad/s^2.
        curvature: d'', m/s^3 and rad/s^3.
        duration: T [s].
        acceleration_mismatch: m/s^2 and rad/s^2; None until it is known.
        older: mismatches of latches before, which still fade.
    """

    rate: Vector
    curvature: Vector
    duration: float
    acceleration_mismatch: Vector | None = None
    older: tuple[Mismatch, ...] = ()

    @classmethod
    def none(cls, n: int, duration: float) -> GapMotion:
        """Return that of a gap which does not move."""
        zeros = np.zeros(n)
        return cls(zeros, zeros, duration)

    def with_columns(self, columns: Columns, other: GapMotion) -> GapMotion:
        """Return it with the motion of another one on some joints, where it has none itself."""
        rate, curvature = self.rate.copy(), self.curvature.copy()
        rate[columns], curvature[columns] = other.rate[columns], other.curvature[columns]
        older = tuple((_on(columns, mismatch), age, tau) for mismatch, age, tau in other.older)
        return replace(self, rate=rate, curvature=curvature, older=(*self.older, *older))

    def at(self, elapsed: float) -> Vector:
        """Return its part of the gap ``elapsed`` seconds after the latch, shape (n,)."""
        value = self.lasting(elapsed)
        if self.acceleration_mismatch is not None:
            tau = min(_SHORT, self.duration)
            value += (tau * _quintics(elapsed / tau)[0]) * self.acceleration_mismatch
        for mismatch, age, tau in self.older:
            value += (tau * _quintics((age + elapsed) / tau)[0]) * mismatch
        return value

    def lasting(self, elapsed: float) -> Vector:
        """Return what ``at`` does, without the mismatches."""
        by_rate, by_curvature = _quintics(elapsed / self.duration)
        value = (self.duration * by_rate) * self.rate
        value += (self.duration**2 * by_curvature) * self.curvature
        return value

    def fading(self, elapsed: float) -> tuple[Mismatch, ...]:
        """Return the mismatches that still fade ``elapsed`` seconds after the latch."""
        mismatches = [(mismatch, age + elapsed, tau) for mismatch, age, tau in self.older]
        if self.acceleration_mismatch is not None:
            mismatches.append((self.acceleration_mismatch, elapsed, min(_SHORT, self.duration)))
        return tuple(entry for entry in mismatches if entry[1] < entry[2])


def with_mismatch(
    gap_motion: GapMotion | None,
    moved: Vector,
    columns: Columns,
    duration: float,
    context: TickContext,
) -> GapMotion | None:
    """Return the motion of a gap, now that the source's step from tick to tick is known.

    Args:
        gap_motion: what was known at the latch, None where the gap had no motion.
        moved: the command's step at the latch less the source's step after it, shape (n,).
        columns: the joints of the robots on their way.
        duration: of the blend [s].
        context: of the tick after the latch.
    """
    # Over dt the difference of the two steps is the gap's rate. What ``gap_motion`` has of it
    # already is taken off.
    mismatch = moved / context.dt
    limit = context.limits.acceleration
    if gap_motion is not None:
        mismatch -= (
            (gap_motion.at(context.dt) - gap_motion.at(0.0)) / context.dt
            if gap_motion.older
            else gap_motion.rate
        )
    # Joint by joint, so that robots do not affect each other. At most the acceleration limit; a
    # difference far beyond it is no acceleration, but a jump of the source, and counts as none.
    size = np.abs(mismatch)
    np.minimum(np.maximum(mismatch, -limit), limit, out=mismatch)
    mismatch[(size <= _FELT * limit) | (size > _JUMP * limit)] = 0.0
    if not mismatch[columns].any():
        return gap_motion
    return replace(
        gap_motion or GapMotion.none(mismatch.size, duration), acceleration_mismatch=mismatch
    )


def _on(columns: Columns, vector: Vector) -> Vector:
    """Return a vector with all but some joints set to zero."""
    kept = np.zeros_like(vector)
    kept[columns] = vector[columns]
    return kept


def _quintics(s: float) -> tuple[float, float]:
    """Return H_1(s) and H_2(s), 0 from s = 1 on."""
    if s >= 1.0:
        return 0.0, 0.0
    return s * (1.0 - s) ** 3 * (1.0 + 3.0 * s), 0.5 * s * s * (1.0 - s) ** 3
