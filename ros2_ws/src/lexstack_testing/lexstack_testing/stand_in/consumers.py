"""What controllers of ros2_control make of messages, at 1 kHz."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from lexstack.types import Vector
from lexstack_plant.hardware.spline import Point, Quintic

_TIMEOUT = 0.25  # s after which a platform without commands stops


class ArmConsumer(ABC):
    """A controller of one arm; where it leads the arm at a time."""

    @abstractmethod
    def take(self, command: Sequence[Point] | Vector, now: float) -> None:
        """Take a message at ``now`` [s]: a trajectory with absolute times, or an array (n,)."""

    @abstractmethod
    def at(self, now: float) -> Vector:
        """Return the position that the drives are asked for at ``now`` [s], shape (n,)."""


class TrajectoryConsumer(ArmConsumer):
    """As joint_trajectory_controller: quintics between points, from where it is when one comes."""

    def __init__(self, q: Vector) -> None:
        """Hold a position, shape (n,)."""
        still = np.zeros_like(q)
        self._path: list[Point] = [Point(-np.inf, q.copy(), still, still)]
        self._segment: Quintic | None = None  # from the first point of the path to the second

    def take(self, command: Sequence[Point] | Vector, now: float) -> None:
        """Replace what is left of the trajectory; points of the past are left out."""
        coming = [point for point in command if isinstance(point, Point) and point.time > now]
        if coming:
            self._path = [self._sample(now), *coming]
            self._segment = None

    def at(self, now: float) -> Vector:
        """Return the position at ``now`` [s], shape (n,)."""
        segment = self._find(now)
        return self._path[0].position if segment is None else segment.position(now)

    def _sample(self, now: float) -> Point:
        """Return the point at ``now`` [s]; after the end the last one, at rest."""
        segment = self._find(now)
        if segment is not None:
            return segment.point(now)
        still = np.zeros_like(self._path[0].position)
        return Point(now, self._path[0].position, still, still)

    def _find(self, now: float) -> Quintic | None:
        """Return the segment of a time; None: it is after the end."""
        path = self._path
        while len(path) > 1 and path[1].time <= now:
            del path[0]
            self._segment = None
        if self._segment is None and len(path) > 1:
            self._segment = Quintic(path[0], path[1])
        return self._segment


class PositionConsumer(ArmConsumer):
    """As forward_command_controller with positions: straight to the newest one in a period."""

    def __init__(self, q: Vector, period: float) -> None:
        """Hold a position, shape (n,); commands come every ``period`` [s]."""
        self._from, self._to = q.copy(), q.copy()
        self._begun, self._period = -np.inf, period

    def take(self, command: Sequence[Point] | Vector, now: float) -> None:
        """Go to a position, shape (n,)."""
        self._from, self._to, self._begun = self.at(now), np.array(command), now

    def at(self, now: float) -> Vector:
        """Return the position at ``now`` [s], shape (n,)."""
        share = min((now - self._begun) / self._period, 1.0)
        return self._from + share * (self._to - self._from)


class VelocityConsumer(ArmConsumer):
    """As forward_command_controller with velocities: to the newest one in a period, straight."""

    def __init__(self, q: Vector, period: float) -> None:
        """Stand at a position, shape (n,); commands come every ``period`` [s]."""
        self._q, self._last = q.copy(), 0.0
        self._from, self._to = np.zeros_like(q), np.zeros_like(q)
        self._begun, self._period = -np.inf, period

    def take(self, command: Sequence[Point] | Vector, now: float) -> None:
        """Go on at a velocity, shape (n,)."""
        self._from, self._to, self._begun = self._velocity(now), np.array(command), now

    def at(self, now: float) -> Vector:
        """Return the position at ``now`` [s], shape (n,); asked for again and again, in order."""
        elapsed, self._last = now - self._last, now
        if 0.0 < elapsed < self._period:
            self._q = self._q + elapsed * self._velocity(now)
        return self._q

    def _velocity(self, now: float) -> Vector:
        """Return the velocity at ``now`` [s], shape (n,)."""
        share = min((now - self._begun) / self._period, 1.0)
        return self._from + share * (self._to - self._from)


class BaseConsumer:
    """A platform's controller: it follows twists within its acceleration limits, and times out."""

    def __init__(self, acceleration: Vector) -> None:
        """Stand still; ``acceleration`` limits have shape (3,)."""
        self._acceleration = acceleration
        self._wanted: Vector = np.zeros(3)
        self._twist: Vector = np.zeros(3)
        self._heard = -np.inf

    def take(self, twist: Vector, now: float) -> None:
        """Take a twist along the platform's axes, shape (3,)."""
        self._wanted, self._heard = np.array(twist), now

    def step(self, now: float, period: float) -> Vector:
        """Return the twist of the next ``period`` [s], shape (3,)."""
        wanted = self._wanted if now - self._heard < _TIMEOUT else np.zeros(3)
        most = self._acceleration * period
        self._twist = self._twist + np.minimum(np.maximum(wanted - self._twist, -most), most)
        return self._twist
