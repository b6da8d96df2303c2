"""A set-point and the way on which the reference is led to it.

A target that steps would make level 1 of every stack step too: b = K e jumps, and the command
follows with full acceleration. The reference therefore moves to a new goal along

    x(t) = goal (+) gap(t),        gap(t) = (1 - a) gap0 + T H_1 gap0' + T^2 H_2 gap0''

with s = t / T, a(s) = 10 s^3 - 15 s^4 + 6 s^5, H_1(s) = s (1 - s)^3 (1 + 3 s) and
H_2(s) = s^2 (1 - s)^3 / 2: the quintic that starts with the position, velocity and acceleration
that the reference has, and ends at rest. A new goal on the way therefore changes neither velocity
nor acceleration of the reference. A goal may move itself: ``Led`` is the same way to a trajectory.

The velocity of the way to a set-point is not added to what tasks ask for (``rate`` is None), so
tasks follow it by their gains alone; but it is added where the reference leaves a trajectory whose
velocity was added until then, as this velocity would jump to zero otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar, cast

import numpy as np

from lexstack.references.fading import Fading, faded
from lexstack.references.spaces import BASES, POSES, Space
from lexstack.references.trajectory import Trajectory
from lexstack.robots import Pose
from lexstack.types import Vector

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class SetPoint(Generic[T]):
    """A goal, and what is left of the way to it.

    Attributes:
        goal: a pose, or x, y, yaw, or positions of joints.
        fading: the way; None: the reference is the goal.
        space: of the goal; None: that of poses, or of bases.
        fed: whether the velocity on the way is added to what tasks ask for.
    """

    goal: T
    fading: Fading | None = None
    space: Space[T] | None = None
    fed: bool = False

    @property
    def end(self) -> float:
        """The time from which it rests [s]."""
        return -np.inf if self.fading is None else self.fading.start + self.fading.duration

    def settled(self, stamp: float) -> bool:
        """Return whether the reference is the goal at a time [s], and from then on."""
        return self.fading is None or self.fading.over(stamp)

    def at(self, stamp: float, space: Space[T] | None = None) -> T:
        """Return the reference at a time [s]; the goal itself, not a copy, once it is there."""
        if self.fading is None or self.fading.over(stamp):
            return self.goal
        return (space or self._space).moved(self.goal, self.fading.at(stamp))

    def rate(self, stamp: float) -> Vector | None:
        """Return its velocity at a time [s] where it is ``fed``; None: at rest, or not fed."""
        if not self.fed or self.fading is None or self.fading.over(stamp):
            return None
        gap, rate = self.fading.at(stamp), self.fading.rate_at(stamp)
        return self._space.velocity(self.goal, np.zeros_like(gap), gap, rate)

    def led_to(self, goal: T, stamp: float, duration: float, space: Space[T]) -> SetPoint[T]:
        """Return the way from here to another goal, see ``led``."""
        return led(self, goal, stamp, duration, space)

    @property
    def _space(self) -> Space[T]:
        """Return the kind of the goal."""
        known = POSES if isinstance(self.goal, Pose) else BASES
        return self.space or cast("Space[T]", known)


@dataclass(frozen=True, slots=True, eq=False)
class Led(Generic[T]):
    """A trajectory, and what is left of the way to it: ``goal(t) (+) gap(t)``.

    Attributes:
        goal: where the way ends; it moves itself.
        fading: the way.
        space: of the goal.
    """

    goal: Trajectory[T]
    fading: Fading
    space: Space[T]

    @property
    def end(self) -> float:
        """The time from which it rests [s]."""
        return max(self.goal.end, self.fading.start + self.fading.duration)

    def at(self, stamp: float) -> T:
        """Return the reference at a time [s]."""
        goal = self.goal.at(stamp)
        return goal if self._over(stamp) else self.space.moved(goal, self.fading.at(stamp))

    def rate(self, stamp: float) -> Vector | None:
        """Return its velocity at a time [s]."""
        rate = self.goal.rate(stamp)
        if self._over(stamp):
            return rate
        gap, gap_rate = self.fading.at(stamp), self.fading.rate_at(stamp)
        rate = np.zeros_like(gap) if rate is None else rate
        return self.space.velocity(self.goal.at(stamp), rate, gap, gap_rate)

    def _over(self, stamp: float) -> bool:
        """Return whether the way is over; it is not before ``end``, so that it rests from there."""
        return stamp >= self.fading.start + self.fading.duration


def settled(motion: Trajectory[T], stamp: float) -> bool:
    """Return whether a reference rests at a time [s], and from then on."""
    return motion.settled(stamp) if isinstance(motion, SetPoint) else stamp >= motion.end


def unled(motion: Trajectory[T]) -> Trajectory[T]:
    """Return what a reference leads to: a set-point, or a trajectory, without the way to it."""
    if isinstance(motion, Led):
        return motion.goal
    return SetPoint(motion.goal, space=motion.space) if isinstance(motion, SetPoint) else motion


def led(
    motion: Trajectory[T],
    goal: T,
    stamp: float,
    duration: float,
    space: Space[T],
    *,
    fed: bool = False,
) -> SetPoint[T]:
    """Return the way from any reference to a set-point.

    Args:
        motion: the reference until now.
        goal: where to.
        stamp: time of the change [s].
        duration: of the way [s]; 0: the reference steps.
        space: of the goals.
        fed: whether tasks shall add the velocity of the way in any case.
    """
    if duration <= 0.0:
        return SetPoint(goal, space=space)
    fed = fed or motion.rate(stamp) is not None
    still = settled(motion, stamp)
    way = faded(lambda t: space.gap(goal, motion.at(t)), stamp, duration, space, still=still)
    return SetPoint(goal, way, space, fed)


def held(motion: Trajectory[T], stamp: float, duration: float, space: Space[T]) -> SetPoint[T]:
    """Return the way from any reference to rest, by as much farther on as it needs for that.

    From the velocity v the quintic ends at v T / 2 without turning back.

    Args:
        motion: the reference until now.
        stamp: time of the change [s].
        duration: T [s].
        space: of its values.
    """
    here = motion.at(stamp)
    if duration <= 0.0 or settled(motion, stamp):
        return SetPoint(here, space=space)
    rate = faded(lambda t: space.gap(here, motion.at(t)), stamp, duration, space).rate
    return led(motion, space.moved(here, 0.5 * duration * rate), stamp, duration, space)


def led_onto(
    motion: Trajectory[T], goal: Trajectory[T], stamp: float, duration: float, space: Space[T]
) -> Trajectory[T]:
    """Return the way from any reference to a trajectory.

    Args:
        motion: the reference until now.
        goal: the trajectory, which goes on meanwhile.
        stamp: time of the change [s].
        duration: of the way [s]; 0: the reference steps.
        space: of their values.
    """
    if duration <= 0.0:
        return goal
    return Led(
        goal, faded(lambda t: space.gap(goal.at(t), motion.at(t)), stamp, duration, space), space
    )
