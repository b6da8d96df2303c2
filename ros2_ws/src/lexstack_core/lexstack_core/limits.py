"""Joint limits that change at run time: no box is ever empty, and the way is as short as can be.

Takes the place of T(34). New limits hold at once, but where a joint cannot keep them:

- outside a position limit, that limit takes its time: it is in its place when the joint is inside;
- in front of one but too fast to stop with a smaller acceleration limit, the joint keeps the old
  one until it stands.

Outside, in the least time: the limit is drawn inside, by the way in which the joint stops from its
velocity limit. That leaves one choice to ``viable_bounds``, full acceleration inward up to the
velocity limit, until the joint has crossed the new limit; ``lateness`` knows when. In a given
time: the limit moves along the quintic, from where the joint can come to rest.

A velocity above its new limit needs no more: the box leads below it with the acceleration limit.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lexstack_core.bounds import JointLimits
from lexstack_core.lateness import Lateness, Motion
from lexstack_core.linear import Vector

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

    @classmethod
    def begin(
        cls, old: JointLimits, new: JointLimits, motion: Motion, tick: int, duration: float = 0.0
    ) -> LimitBlend:
        """Return the way from ``old`` to ``new`` limits for joints in this state of motion.

        Args:
            old: the limits in effect.
            new: the limits to come.
            motion: of the joints at the trigger.
            tick: the tick of the trigger, the first whose box is made from ``at``.
            duration: how long position limits move [s]; 0: the least time.
        """
        late = Lateness.of(old, new, motion)
        if not late.ticks.any():
            return cls(new, tick, (), (), None)
        if duration > 0.0:
            release = tick + max(int(np.ceil(duration / motion.dt - 1e-9)), 1)
            return cls(new, tick, (release,), (_eased(old, new, late.fast),), late.gaps)
        ends = np.unique(late.ticks[late.ticks > 0]).tolist()
        stages = tuple(_drawn(late, old, new, end) for end in ends)
        return cls(new, tick, tuple(tick + end for end in ends), stages, None)

    @property
    def end(self) -> int:
        """The first tick at which ``new`` holds for every joint."""
        return self.releases[-1] if self.releases else self.start

    def at(self, tick: int) -> JointLimits:
        """Return the limits of a tick; the same object for as long as nothing changes."""
        stage = bisect_right(self.releases, tick)
        if stage == len(self.releases):
            return self.new
        limits = self._stages[stage]
        if self._gaps is None:
            return limits
        s = max(tick + 1 - self.start, 0) / (self.end - self.start)
        gaps = (1.0 - s * s * s * (10.0 + s * (6.0 * s - 15.0))) * self._gaps
        return replace(
            limits,
            position_lower=limits.position_lower - gaps[: limits.n],
            position_upper=limits.position_upper + gaps[limits.n :],
        )


def _drawn(late: Lateness, old: JointLimits, new: JointLimits, end: int) -> JointLimits:
    """Return the limits while the joints that are late for ``end`` ticks or more are held."""
    n, held = new.n, late.ticks >= end
    braked = held & late.fast
    lower = np.where(held[:n], -late.drawn_to[:n], new.position_lower)
    upper = np.where(held[n:], late.drawn_to[n:], new.position_upper)
    # A joint that only brakes does not come to the other limit: that may give way.
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
