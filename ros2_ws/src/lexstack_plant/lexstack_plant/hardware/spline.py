"""A trajectory whose acceleration and jerk, at any time, are those of the commands.

A drive that runs at 1 kHz and hears of us at 100 Hz must fill the gaps. If it held each velocity,
every command would be a step; straight lines between them would make steps of the acceleration. So
velocity is the uniform quadratic B-spline with the commands c_k as control points:

    segment between two knots:  velocity from (c_{k-2} + c_{k-1}) / 2 to (c_{k-1} + c_k) / 2,
    at its end the acceleration (c_k - c_{k-1}) / dt, on the way dt (c_{k-2} + 4 c_{k-1} + c_k) / 6

Its acceleration lies between (c_{k-1} - c_{k-2}) / dt and (c_k - c_{k-1}) / dt, its jerk is
(c_k - 2 c_{k-1} + c_{k-2}) / dt^2: what the commands keep from tick to tick, the motion keeps at
every time. Position is a cubic between two knots, so a consumer that interpolates by cubics
(positions and velocities) or quintics (accelerations too) has exactly this motion, also when a new
message comes in the middle of a segment.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from lexstack.limits import JointLimits
from lexstack.types import Matrix, Vector

_REST = 1.5  # T a / v of the stop v (1 - 3 s^2 + 2 s^3), whose largest acceleration is 1.5 v / T
_REST_JERK = 6.0  # T^2 j / v of it
_SHORTEST = 1e-3  # s, of a stop


@dataclass(frozen=True, slots=True)
class Point:
    """Where a trajectory is at a time; vectors have shape (n,).

    Attributes:
        time: s after the stamp of the trajectory.
        position: rad and m.
        velocity: rad/s and m/s.
        acceleration: rad/s^2 and m/s^2.
    """

    time: float
    position: Vector
    velocity: Vector
    acceleration: Vector


class CommandSpline:
    """The B-spline through the commands of one arm, one segment per tick."""

    def __init__(self, limits: JointLimits, dt: float, ahead: int, hold: int) -> None:
        """Make the spline of an arm.

        Args:
            limits: of its joints, for the stop at the end of every trajectory.
            dt: control period [s].
            ahead: points that later trajectories do not change.
            hold: ticks that the motion goes on beyond them before it stops.
        """
        self._limits = limits
        self._dt = dt
        self._hold = hold
        self._knots: deque[Point] = deque(maxlen=ahead)
        self._before: Vector = np.zeros(limits.n)
        self._last: Vector = np.zeros(limits.n)
        # Positions at the knots, from the one of now to the newest one.
        self._path: deque[Vector] = deque([np.zeros(limits.n)], maxlen=ahead + 1)

    def begin(self, position: Vector, velocity: Vector) -> None:
        """Begin at a measured state, shape (n,) each, that moves on at its velocity."""
        ahead, still = self._knots.maxlen or 1, np.zeros_like(velocity)
        self._before, self._last = velocity.copy(), velocity.copy()
        self._knots.clear()
        self._path.clear()
        self._path.append(position.copy())
        # The next commands are not known; meanwhile the joints move on as they do.
        for k in range(ahead):
            self._path.append(position + (k + 1) * self._dt * velocity)
            self._knots.append(Point(0.0, self._path[-1], velocity.copy(), still))

    def push(self, chi: Vector) -> None:
        """Add the segment of a command, shape (n,)."""
        dt, before, last = self._dt, self._before, self._last
        self._path.append(self._path[-1] + dt / 6.0 * (before + 4.0 * last + chi))
        velocity, acceleration = 0.5 * (last + chi), (chi - last) / dt
        self._knots.append(Point(0.0, self._path[-1], velocity, acceleration))
        self._before, self._last = last, chi.copy()

    @property
    def led(self) -> Vector:
        """Where the arm is led now, shape (n,)."""
        return self._path[0]

    @property
    def position(self) -> Vector:
        """Where the arm is led at the newest knot, shape (n,)."""
        return self._path[-1]

    @property
    def in_flight(self) -> Vector:
        """How far the commands so far will still move the arm, shape (n,).

        Every command moves it by dt c in all, of which the last two have some left after the newest
        knot: dt (c_{k-1} + 5 c_k) / 6.
        """
        left = self._dt / 6.0 * (self._before + 5.0 * self._last)
        return self._path[-1] + left - self._path[0]

    def points(self) -> list[Point]:
        """Return the trajectory from now on: its knots, and how it ends if nothing more comes.

        The end: the last velocity for ``hold`` ticks, then a stop within the limits. A consumer
        whose messages end comes to rest by itself.
        """
        dt = self._dt
        knots = [
            Point(dt * (k + 1), knot.position, knot.velocity, knot.acceleration)
            for k, knot in enumerate(self._knots)
        ]
        return [*knots, *self._end()]

    def _end(self) -> list[Point]:
        """Return how the motion ends after the newest knot."""
        if not self._last.any() and not self._before.any():
            return []
        dt, limits, knot = self._dt, self._limits, self._knots[-1]
        still = np.zeros_like(knot.velocity)
        # The acceleration fades at a steady jerk: in one period, as if the command were repeated,
        # or in as long as the limits need.
        fade = max(dt, float((np.abs(knot.acceleration) / limits.jerk).max()))
        v = knot.velocity + 0.5 * fade * knot.acceleration
        way = fade * (knot.velocity + fade / 3.0 * knot.acceleration)
        time, position = dt * len(self._knots) + fade, knot.position + way
        points = [Point(time, position, v, still)]
        if self._hold:
            time, position = time + self._hold * dt, position + self._hold * dt * v
            points.append(Point(time, position, v, still))
        speed = np.abs(v)
        stop = max(
            _SHORTEST,
            _REST * float((speed / limits.acceleration).max()),
            float(np.sqrt(_REST_JERK * speed / limits.jerk).max()),
        )
        points.append(Point(time + stop, position + 0.5 * stop * v, still, still))
        return points


class Quintic:
    """The motion between two points as consumers make it, of degree 5 in time."""

    def __init__(self, start: Point, end: Point) -> None:
        """Take two points, the second one later than the first."""
        self._start, self._span = start.time, end.time - start.time
        span = self._span
        p0, v0, a0 = start.position, start.velocity * span, start.acceleration * span * span
        p1, v1, a1 = end.position, end.velocity * span, end.acceleration * span * span
        c3 = 10.0 * (p1 - p0) - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
        c4 = -15.0 * (p1 - p0) + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
        c5 = 6.0 * (p1 - p0) - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1
        self._c: Matrix = np.array([p0, v0, 0.5 * a0, c3, c4, c5])

    def position(self, time: float) -> Vector:
        """Return the position at ``time`` [s], shape (n,)."""
        s = (time - self._start) / self._span
        powers = np.array([1.0, s, s * s, s**3, s**4, s**5])
        position: Vector = powers @ self._c
        return position

    def positions(self, times: Vector) -> Matrix:
        """Return the positions at ``times`` (k,) [s], shape (k, n)."""
        s = (times - self._start) / self._span
        positions: Matrix = np.vander(s, 6, increasing=True) @ self._c
        return positions

    def point(self, time: float) -> Point:
        """Return the point at ``time`` [s]."""
        s, span = (time - self._start) / self._span, self._span
        slope = np.array([0.0, 1.0, 2.0 * s, 3.0 * s * s, 4.0 * s**3, 5.0 * s**4])
        bend = np.array([0.0, 0.0, 2.0, 6.0 * s, 12.0 * s * s, 20.0 * s**3])
        return Point(
            time, self.position(time), slope @ self._c / span, bend @ self._c / (span * span)
        )
