"""A set-point and the way on which the reference is led to it.

A target that steps would make level 1 of every stack step too: b = K e jumps, and the command
follows with full acceleration. The reference therefore moves to a new goal along

    x(t) = goal (+) gap(t),        gap(t) = (1 - a) gap0 + T H_1 gap0' + T^2 H_2 gap0''

with s = t / T, a(s) = 10 s^3 - 15 s^4 + 6 s^5, H_1(s) = s (1 - s)^3 (1 + 3 s) and
H_2(s) = s^2 (1 - s)^3 / 2: the quintic that starts with the position, velocity and acceleration
that the reference has, and ends at rest. A new goal on the way therefore changes neither velocity
nor acceleration of the reference.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
import pinocchio as pin

from lexstack.robots import Pose
from lexstack.robots.spatial import log3, wrap
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


class Space(Protocol[T]):
    """What a set-point needs of the kind of its goal."""

    def gap(self, goal: T, value: T) -> Vector:
        """Return ``value`` as seen from ``goal``."""
        ...

    def moved(self, goal: T, gap: Vector) -> T:
        """Return what is a gap away from ``goal``: the inverse of ``gap``."""
        ...


class Poses:
    """Poses: the gap is a translation in the world and a rotation vector in the goal's axes."""

    def gap(self, goal: Pose, value: Pose) -> Vector:
        """Return p - p_goal [m] and log(R_goal^T R) [rad], shape (6,)."""
        turn = log3(goal.rotation.T @ value.rotation)
        return np.concatenate((value.position - goal.position, turn))

    def moved(self, goal: Pose, gap: Vector) -> Pose:
        """Return the pose with position p_goal + gap[:3] and rotation R_goal exp(gap[3:])."""
        turn = np.asarray(pin.exp3(gap[3:]))
        return Pose(goal.position + gap[:3], goal.rotation @ turn)


class Bases:
    """Planar poses x, y [m], yaw [rad]; the gap takes the short way round."""

    def gap(self, goal: Vector, value: Vector) -> Vector:
        """Return the difference, its yaw in (-pi, pi], shape (3,)."""
        x, y, yaw = (float(one) for one in value - goal)
        return np.array([x, y, wrap(yaw)])

    def moved(self, goal: Vector, gap: Vector) -> Vector:
        """Return the sum, shape (3,)."""
        return np.asarray(goal + gap)


POSES = Poses()
"""How references of tools are compared and led in."""
BASES = Bases()
"""How references of bases are compared and led in."""


@dataclass(frozen=True, slots=True, eq=False)
class SetPoint(Generic[T]):
    """A goal, and what is left of the way to it.

    Attributes:
        goal: a pose, or x, y, yaw.
        fading: the way; None: the reference is the goal.
    """

    goal: T
    fading: Fading | None = None

    def settled(self, stamp: float) -> bool:
        """Return whether the reference is the goal at a time [s], and from then on."""
        return self.fading is None or self.fading.over(stamp)

    def at(self, stamp: float, space: Space[T]) -> T:
        """Return the reference at a time [s]; the goal itself, not a copy, once it is there."""
        if self.fading is None or self.fading.over(stamp):
            return self.goal
        return space.moved(self.goal, self.fading.at(stamp))

    def led_to(self, goal: T, stamp: float, duration: float, space: Space[T]) -> SetPoint[T]:
        """Return the way to another goal.

        Args:
            goal: where to.
            stamp: time of the change [s].
            duration: of the way [s]; 0: the reference steps.
            space: of the goals.
        """
        if duration <= 0.0:
            return SetPoint(goal)
        gap = space.gap(goal, self.at(stamp, space))
        if self.settled(stamp):
            zeros = np.zeros_like(gap)
            return SetPoint(goal, Fading(stamp, duration, gap, zeros, zeros))
        before, after = (
            _nearest(space.gap(goal, self.at(stamp + step, space)), gap) for step in (-_STEP, _STEP)
        )
        rate = (after - before) / (2.0 * _STEP)
        curvature = (after - 2.0 * gap + before) / _STEP**2
        return SetPoint(goal, Fading(stamp, duration, gap, rate, curvature))


def _nearest(gap: Vector, other: Vector) -> Vector:
    """Return a gap with its angles in the turn that is nearest to another gap's.

    A rotation by nearly pi has two vectors, a yaw of nearly pi two signs: a difference between
    them would be taken for a speed.
    """
    if len(gap) == len(other) == 3:
        return np.array([gap[0], gap[1], other[2] + wrap(float(gap[2] - other[2]))])
    turn = gap[3:]
    angle = math.sqrt(float(turn @ turn))
    if angle and float(np.abs(turn - other[3:]).max()) > math.pi:
        turn = turn * (1.0 - 2.0 * math.pi / angle)
    return np.concatenate((gap[:3], turn))
