"""The limits in force at every tick, and the controller's box that keeps them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import is_not
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lexstack.limits.joint_limits import LIMITS, Bounds, JointLimits
from lexstack.limits.limit_timing import Motion
from lexstack.limits.limit_transition import LimitBlend
from lexstack.limits.viable_bounds import is_viable, viable_bounds
from lexstack.types import RobotState, Vector


@dataclass(frozen=True, slots=True)
class LimitOptions:
    """How limits are kept.

    Attributes:
        dt: control period [s].
        jerk: whether jerk is limited at every tick.
        duration: how long position limits move that a stack changes [s]; 0: the least time.
    """

    dt: float
    jerk: bool = False
    duration: float = 0.0


class BoundsProvider(Protocol):
    """What the controller needs of its limits."""

    @property
    def dt(self) -> float:
        """The control period [s]."""
        ...

    def at(
        self, state: RobotState, wanted: JointLimits, sent: Vector | None, *, jerk: bool
    ) -> tuple[JointLimits, Bounds]:
        """Return the limits of this tick and the box; see ``LimitsInForce``."""
        ...


class LimitsInForce:
    """From the limits that a stack asks for to those that can be kept; one call per tick.

    Other limits than those of the tick before begin a ``LimitBlend`` from where the joints are,
    whatever the reason: a trigger, a new one in mid-blend, or a way back. Joints whose limits do
    not change go on as they were: a switch of one robot holds up no limits of another one.

    Where jerk limits come into force or become tighter, a joint may be too fast for them in front
    of a limit that it can keep without. Such a joint comes under them as soon as it can.
    """

    def __init__(
        self,
        own: JointLimits,
        options: LimitOptions,
        positions: Callable[[Vector], Vector] | None = None,
    ) -> None:
        """Start with the robots' own limits in force, and no jerk limit.

        Args:
            own: of the robots.
            options: how they are kept.
            positions: ``Team.joint_positions``; None: q is as long as chi.
        """
        self._options = options
        self._positions = positions
        self._blend = LimitBlend.settled(own)
        # Blends before it, each with the joints, shape (n,), whose limits have not changed since.
        self._going: list[tuple[NDArray[np.bool_], LimitBlend]] = []
        self._pieces: tuple[JointLimits, ...] = ()  # what ``_whole`` was put together from
        self._whole = own
        self._endless: Vector = np.full(own.n, np.inf)
        self._jerk = self._endless  # in force at the last tick
        self._base: JointLimits | None = None  # what ``_kept`` was made from
        self._kept = own
        self._before: RobotState | None = None

    @property
    def dt(self) -> float:
        """The control period [s]."""
        return self._options.dt

    def at(
        self, state: RobotState, wanted: JointLimits, sent: Vector | None, *, jerk: bool
    ) -> tuple[JointLimits, Bounds]:
        """Return the limits of this tick, and the box of all chi that keep them.

        Args:
            state: of the plant.
            wanted: the limits to come to; they are told apart by identity.
            sent: the command that was sent last, shape (n,); see ``viable_bounds``.
            jerk: whether jerk is limited at this tick; it is in any case where the options say so.
        """
        dt, limited = self._options.dt, jerk or self._options.jerk
        before, self._before = self._before, state
        acceleration = self._acceleration(state, before) if limited else None
        place = state.q_star if self._positions is None else self._positions(state.q_star)
        motion = Motion(place, state.command, dt, acceleration)
        if wanted is not self._blend.new:
            old = replace(self._at(state.tick), jerk=self._jerk)
            self._keep_going(wanted, state.tick)
            options = (state.tick, self._options.duration)
            self._blend = LimitBlend.begin(old, wanted, motion, *options)
        limits = self._at(state.tick)
        kept = self._within_jerk(limits, motion)
        box = viable_bounds(place, kept, dt, state.command, sent, motion.acceleration)
        return limits, box

    def _at(self, tick: int) -> JointLimits:
        """Return the limits of a tick, of every joint by the blend that moves them."""
        if not self._going:
            return self._blend.at(tick)
        if all(tick >= blend.end for blend in (self._blend, *(blend for _, blend in self._going))):
            self._going = []
            return self._blend.at(tick)
        pieces = (self._blend.at(tick), *(blend.at(tick) for _, blend in self._going))
        if len(pieces) != len(self._pieces) or any(map(is_not, pieces, self._pieces)):
            going = zip((joints for joints, _ in self._going), pieces[1:], strict=True)
            self._pieces, self._whole = pieces, pieces[0].replaced(going)
        return self._whole

    def _keep_going(self, wanted: JointLimits, tick: int) -> None:
        """Let the blends under way go on for the joints whose limits stay what they are."""
        before = self._blend.new
        same = np.logical_and.reduce(
            [getattr(wanted, name) == getattr(before, name) for name in LIMITS]
        )
        under_way = []
        for joints, blend in (*self._going, (same, self._blend)):
            mine = joints & same
            same = same & ~mine
            if mine.any():
                going = blend if tick < blend.end else LimitBlend.settled(wanted)
                under_way.append((mine, going))
        self._going = under_way

    def _acceleration(self, state: RobotState, before: RobotState | None) -> Vector:
        """Return the acceleration of the last tick, shape (n,); over a gap in the ticks the mean.

        Nothing is known before the second state: the plant is taken to have moved uniformly.
        """
        if before is None or before.tick >= state.tick:
            return np.zeros_like(state.command)
        elapsed = (state.tick - before.tick) * self._options.dt
        return (state.command - before.command) / elapsed

    def _within_jerk(self, limits: JointLimits, motion: Motion) -> JointLimits:
        """Return the limits with the jerk limits that the joints can keep already."""
        if motion.acceleration is None:
            self._jerk, self._base = self._endless, None
            return limits
        if limits is not self._base or self._kept is not limits:
            former = replace(limits, jerk=self._jerk)
            state = (motion.dt, motion.applied, motion.acceleration)
            waits = is_viable(motion.position, former, *state)
            waits &= ~is_viable(motion.position, limits, *state)
            jerk = np.where(waits, self._jerk, limits.jerk)
            self._kept = replace(limits, jerk=jerk) if waits.any() else limits
            self._jerk, self._base = self._kept.jerk, limits
        return self._kept
