"""What controllers of ros2_control make of messages, sampled at 1 kHz."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from lexstack.types import Matrix, Vector
from lexstack_plant.hardware.spline import Point, Quintic

_TIMEOUT = 0.25  # s after which a platform without commands stops


class ArmConsumer(ABC):
    """A controller of one arm; where it leads the arm at times that only grow."""

    @abstractmethod
    def take(self, command: Sequence[Point] | Vector, now: float) -> None:
        """Take a message at ``now`` [s]: a trajectory with absolute times, or an array (n,)."""

    @abstractmethod
    def path(self, times: Vector) -> Matrix:
        """Return the positions that the drives are asked for at ``times`` (k,) [s], (k, n)."""


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

    def path(self, times: Vector) -> Matrix:
        """Return the positions at ``times`` (k,) [s], shape (k, n)."""
        result = np.empty((len(times), len(self._path[0].position)))
        done = 0
        while done < len(times):
            segment = self._find(float(times[done]))
            if segment is None:
                result[done:] = self._path[0].position
                break
            end = int(np.searchsorted(times, self._path[1].time))
            result[done:end] = segment.positions(times[done:end])
            done = end
        return result

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
        self._from, self._to = self.path(np.array([now]))[0], np.array(command)
        self._begun = now

    def path(self, times: Vector) -> Matrix:
        """Return the positions at ``times`` (k,) [s], shape (k, n)."""
        return _line(self._from, self._to, (times - self._begun) / self._period)


class VelocityConsumer(ArmConsumer):
    """As forward_command_controller with velocities: to the newest one in a period, straight."""

    def __init__(self, q: Vector, period: float) -> None:
        """Stand at a position, shape (n,); commands come every ``period`` [s]."""
        self._q, self._last = q.copy(), np.inf
        self._from, self._to = np.zeros_like(q), np.zeros_like(q)
        self._begun, self._period = -np.inf, period

    def take(self, command: Sequence[Point] | Vector, now: float) -> None:
        """Go on at a velocity, shape (n,)."""
        self._from, self._to = self._velocities(np.array([now]))[0], np.array(command)
        self._begun = now

    def path(self, times: Vector) -> Matrix:
        """Return the positions at ``times`` (k,) [s], shape (k, n): the integral of velocities."""
        first = min(self._last, float(times[0]))  # at the very first time nothing has elapsed
        elapsed = np.diff(times, prepend=first)
        result = self._q + np.cumsum(elapsed[:, None] * self._velocities(times), axis=0)
        self._q, self._last = result[-1], float(times[-1])
        return result

    def _velocities(self, times: Vector) -> Matrix:
        """Return the velocities at ``times`` (k,) [s], shape (k, n)."""
        return _line(self._from, self._to, (times - self._begun) / self._period)


class BaseConsumer:
    """A platform's controller: it follows twists within its acceleration limits, and times out."""

    def __init__(self, acceleration: Vector) -> None:
        """Stand still; ``acceleration`` limits have shape (m,), one for each part of the twist."""
        self._acceleration = acceleration
        self._wanted: Vector = np.zeros_like(acceleration)
        self._twist: Vector = np.zeros_like(acceleration)
        self._heard = -np.inf

    def take(self, twist: Vector, now: float) -> None:
        """Take a twist along the platform's axes, shape (m,)."""
        self._wanted, self._heard = np.array(twist), now

    def path(self, times: Vector, period: float) -> Matrix:
        """Return the twists of the periods [s] that end at ``times`` (k,), shape (k, m)."""
        result = np.empty((len(times), len(self._twist)))
        heard = int(np.searchsorted(times, self._heard + _TIMEOUT))
        for part, wanted in (
            (slice(0, heard), self._wanted),
            (slice(heard, None), np.zeros_like(self._twist)),
        ):
            rows = result[part]
            if len(rows):
                most = period * np.arange(1, len(rows) + 1)[:, None] * self._acceleration
                rows[:] = self._twist + np.minimum(np.maximum(wanted - self._twist, -most), most)
                self._twist = rows[-1].copy()
        return result


def _line(start: Vector, end: Vector, shares: Vector) -> Matrix:
    """Return points (k, n) of the way from one to the other, at ``shares`` (k,), at most 1."""
    return start + np.minimum(shares, 1.0)[:, None] * (end - start)
