"""Joint limits that change at run time, such that the box of a tick is never empty.

This replaces T(34). New limits hold at once, with two exceptions:

- A joint outside a new position limit cannot be inside at once. The limit reaches its place when
  the joint is inside.
- A joint in front of a limit that is too fast to stop with a smaller acceleration limit keeps the
  old acceleration limit until it stands.

A joint outside, in the least time: the limit is drawn inside by the distance in which the joint
stops from its velocity limit. That leaves ``viable_bounds`` one choice, full acceleration inward up
to the velocity limit, until the joint has crossed the new limit; ``limit_timing`` computes when. In
a given time: the limit moves along the quintic, from where the joint can come to rest. If it moves
faster than the box can follow, the joint goes on to the new limit as fast as it can.

A joint that brakes with the old acceleration does so at once and until it stands, whatever time is
given: before that it cannot keep the limits with the new one.

A velocity above its new limit needs no exception: the box leads below it within the acceleration
limit.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lexstack.limits.joint_limits import JointLimits
from lexstack.limits.limit_timing import LimitTiming, Motion
from lexstack.types import Vector

__all__ = ["LimitBlend", "Motion"]


@dataclass(frozen=True, slots=True, eq=False)
class LimitBlend:
    """The limits of every tick from a trigger on; made by ``begin``.

    Attributes:
        new: the limits that hold in the end.
        start: the tick of the trigger.
        releases: the ticks at which late joints come under ``new``, increasing.
    """

    new: JointLimits
    start: int
    releases: tuple[int, ...]
    _stages: tuple[JointLimits, ...]  # the limits before each release
    _gaps: Vector | None  # from the new to the first position limits, outward, shape (2n,)
    _moving: int = 0  # for how many ticks the gaps close

    @classmethod
    def settled(cls, limits: JointLimits) -> LimitBlend:
        """Return limits that hold as they are."""
        return cls(limits, 0, (), (), None)

    @classmethod
    def begin(
        cls, old: JointLimits, new: JointLimits, motion: Motion, tick: int, duration: float = 0.0
    ) -> LimitBlend:
        """Return the limits from tick to tick, from ``old`` to ``new``, for joints in this motion.

        Args:
            old: the limits in effect.
            new: the limits to come.
            motion: of the joints at the trigger.
            tick: the tick of the trigger, the first whose box is made from ``at``.
            duration: how long position limits move [s]; 0: the least time.
        """
        late = LimitTiming.of(old, new, motion)
        # The given time in whole ticks; 1e-9 of a tick absorbs the rounding of the quotient. It is
        # for the joints whose position limit moves along the quintic. ``fast`` joints are not among
        # them: they keep the old acceleration until they stand, however long that takes.
        given = int(np.ceil(duration / motion.dt - 1e-9))
        moved = (late.ticks > 0) & ~late.fast if given > 0 else np.zeros(2 * new.n, dtype=np.bool_)
        ticks = np.where(moved, given, late.ticks)
        # Each late joint is released at its own tick. Between two releases the limits are constant
        # (but for the quintic), so there is one stage for each release: in the stage that ends at
        # ``end``, the joints that are released then or later are still held. ``unique`` sorts, so
        # ``releases`` increase, as the bisection in ``at`` needs.
        ends = np.unique(ticks[ticks > 0]).tolist()
        stages = tuple(_drawn(late, (ticks >= end) & ~moved, old, new) for end in ends)
        # A moving limit begins where the joint can come to rest, and not at the old limit.
        gaps = np.where(moved, late.gaps, 0.0) if moved.any() else None
        return cls(new, tick, tuple(tick + end for end in ends), stages, gaps, given)

    @property
    def end(self) -> int:
        """The first tick at which ``new`` holds for every joint."""
        return self.releases[-1] if self.releases else self.start

    def at(self, tick: int) -> JointLimits:
        """Return the limits of a tick; the same object for as long as nothing changes."""
        # ``bisect_right``: at the tick of its release a joint is under the new limits already.
        stage = bisect_right(self.releases, tick)
        if stage == len(self.releases):
            return self.new
        # Counted from 1: the box of a tick bounds where the joint is at the end of that tick.
        limits, passed = self._stages[stage], max(tick + 1 - self.start, 0)
        if self._gaps is None or passed >= self._moving:
            return limits
        s = passed / self._moving
        # 1 - alpha(s), with the quintic alpha(s) = 10 s^3 - 15 s^4 + 6 s^5 of the transitions.
        gaps = (1.0 - s * s * s * (10.0 + s * (6.0 * s - 15.0))) * self._gaps
        return replace(
            limits,
            position_lower=limits.position_lower - gaps[: limits.n],
            position_upper=limits.position_upper + gaps[limits.n :],
        )


def _drawn(
    late: LimitTiming, held: NDArray[np.bool_], old: JointLimits, new: JointLimits
) -> JointLimits:
    """Return the limits while the joints that are ``held``, shape (2n,), are drawn inside."""
    # ``drawn_to`` is measured outward: on the lower side it is the negative of a position.
    n, braked = new.n, held & late.fast
    lower = np.where(held[:n], -late.drawn_to[:n], new.position_lower)
    upper = np.where(held[n:], late.drawn_to[n:], new.position_upper)
    # A joint that only brakes does not come to its other limit. That one is moved away until both
    # are ``apart``: where they are closer, ``JerkLaw`` would use less than the full acceleration.
    least, largest = late.drawn_to[n:] - late.apart[n:], late.apart[:n] - late.drawn_to[:n]
    return replace(
        _eased(old, new, braked),
        position_lower=np.where(braked[n:], np.minimum(lower, least), lower),
        position_upper=np.where(braked[:n], np.maximum(upper, largest), upper),
    )


def _eased(old: JointLimits, new: JointLimits, fast: NDArray[np.bool_]) -> JointLimits:
    """Return the new limits with the larger acceleration and jerk where ``fast``, shape (2n,)."""
    either = fast[: new.n] | fast[new.n :]

    def larger(name: str) -> Vector:
        one: Vector = getattr(old, name)
        other: Vector = getattr(new, name)
        return np.where(either, np.maximum(one, other), other)

    return replace(new, acceleration=larger("acceleration"), jerk=larger("jerk"))
