"""A stream of twists of a base, as of a joystick: followed until the next comes, or it is late.

As ``twist_stream`` has it for frames, a ramp leads from the velocity before to the new one, and
another one to rest where no further twist comes in time. Here a velocity may hold in the axes of
the base, which turn with it: driving ahead while turning is an arc. With the velocity u(t) in these
axes, linear in t on the ramp and constant behind it,

    yaw(t) = yaw_0 + int w        p(t) = p_0 + int R(yaw) u

the second integral by Gauss' rule on the ramp, and exactly, as an arc, behind it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.errors import InputError
from lexstack.references.trajectory import Trajectory
from lexstack.types import Vector

_SHORTEST = 1e-3  # s, of a ramp
_STRAIGHT = 1e-9  # rad: an arc of less is a line
# Exact to 1e-12 m where the base turns by less than 2 rad on a ramp of 1 m.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True, slots=True)
class BaseTwist:
    """A velocity that is asked of a base until the next one comes.

    Attributes:
        value: along x and y [m/s], of the yaw [rad/s], shape (3,).
        turning: whether x and y are the axes of the base; otherwise those of the world.
        timeout: after so long without another one the base comes to rest [s].
        linear: largest linear acceleration of the reference, along each axis [m/s2].
        angular: largest angular acceleration of the reference [rad/s2].
    """

    value: Vector
    turning: bool = True
    timeout: float = 0.2
    linear: float = 1.0
    angular: float = 2.0

    def __post_init__(self) -> None:
        """Raise InputError for a value out of range."""
        value = np.array(self.value, dtype=np.float64)
        if value.shape != (3,) or not np.isfinite(value).all():
            raise InputError(f"twist: expected 3 finite numbers, got shape {value.shape}")
        for name in ("timeout", "linear", "angular"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InputError(f"twist: {name}: must be finite and > 0")
        value.setflags(write=False)
        object.__setattr__(self, "value", value)


@dataclass(frozen=True, slots=True, eq=False)
class BaseRamp:
    """From one velocity to another, which then stays.

    Attributes:
        start: time of the beginning [s].
        place: x, y [m], yaw [rad] at the beginning, shape (3,).
        before: velocity at the beginning, in the axes of the twist, shape (3,).
        after: velocity from the end on.
        duration: positive [s].
        turning: as of the twist.
    """

    start: float
    place: Vector
    before: Vector
    after: Vector
    duration: float
    turning: bool

    @classmethod
    def between(
        cls, start: float, place: Vector, before: Vector, twist: BaseTwist, after: Vector
    ) -> BaseRamp:
        """Return the shortest ramp within the acceleration limits of a twist."""
        change = np.abs(after - before)
        duration = max(
            float(change[:2].max()) / twist.linear, float(change[2]) / twist.angular, _SHORTEST
        )
        return cls(start, place, before, after, duration, twist.turning)

    def at(self, stamp: float) -> Vector:
        """Return x, y [m], yaw [rad] at a time [s], not before the start."""
        elapsed = stamp - self.start
        place = self._on_ramp(min(max(elapsed, 0.0), self.duration))
        return self._behind(place, max(elapsed - self.duration, 0.0))

    def rate(self, stamp: float) -> Vector:
        """Return the velocity at a time [s] in the world, shape (3,)."""
        velocity = self.own_rate(stamp)
        return _turned(velocity, float(self.at(stamp)[2])) if self.turning else velocity

    def own_rate(self, stamp: float) -> Vector:
        """Return the velocity at a time [s] in the axes of the twist, shape (3,)."""
        share = min(max((stamp - self.start) / self.duration, 0.0), 1.0)
        return share * self.after + (1.0 - share) * self.before

    def _on_ramp(self, elapsed: float) -> Vector:
        """Return the place after a time on the ramp [s]."""
        risen = 0.5 * elapsed * elapsed / self.duration
        moved = (elapsed - risen) * self.before + risen * self.after
        if self.turning:
            times = 0.5 * elapsed * (1.0 + _NODES)
            shares = times / self.duration
            halves = 0.5 * times * shares
            yaws = self.place[2] + (times - halves) * self.before[2] + halves * self.after[2]
            along = (1.0 - shares)[:, None] * self.before[:2] + shares[:, None] * self.after[:2]
            c, s = np.cos(yaws), np.sin(yaws)
            weights = 0.5 * elapsed * _WEIGHTS
            moved[0] = float(np.sum(weights * (c * along[:, 0] - s * along[:, 1])))
            moved[1] = float(np.sum(weights * (s * along[:, 0] + c * along[:, 1])))
        return self.place + moved

    def _behind(self, place: Vector, elapsed: float) -> Vector:
        """Return the place a time [s] after the end of the ramp, which was at ``place``."""
        moved = elapsed * self.after
        turn = float(moved[2])
        if not self.turning:
            return place + moved
        half = 0.5 * turn
        chord = np.sin(half) / half if abs(half) > _STRAIGHT else 1.0
        moved[:2] *= chord
        return place + _turned(moved, float(place[2]) + half)


@dataclass(frozen=True, slots=True, eq=False)
class BaseTwistStream:
    """A ``Trajectory``: a twist that is followed, and rest where no other one comes in time.

    Attributes:
        twist: that is asked for.
        follow: the ramp to it.
        stop: the ramp to rest.
        goal: x, y [m], yaw [rad] at rest.
    """

    twist: BaseTwist
    follow: BaseRamp
    stop: BaseRamp
    goal: Vector

    @classmethod
    def begun(cls, motion: Trajectory[Vector], stamp: float, twist: BaseTwist) -> BaseTwistStream:
        """Return the stream that goes on from any reference at a time [s].

        A reference whose velocity is not added to what tasks ask for counts as one at rest.
        """
        place, rate = motion.at(stamp), motion.rate(stamp)
        before = np.zeros(3) if rate is None else rate
        if twist.turning:
            before = _turned(before, -float(place[2]))
        return cls.along(BaseRamp.between(stamp, place, before, twist, twist.value), twist)

    @classmethod
    def along(cls, follow: BaseRamp, twist: BaseTwist) -> BaseTwistStream:
        """Return the stream whose ramp to its twist is known."""
        late = follow.start + twist.timeout
        place, before = follow.at(late), follow.own_rate(late)
        stop = BaseRamp.between(late, place, before, twist, np.zeros(3))
        return cls(twist, follow, stop, stop.at(stop.start + stop.duration))

    @property
    def end(self) -> float:
        """The time at which it has come to rest [s]."""
        return self.stop.start + self.stop.duration

    def at(self, stamp: float) -> Vector:
        """Return x, y [m], yaw [rad] at a time [s]."""
        if stamp >= self.end:
            return self.goal
        return (self.follow if stamp < self.stop.start else self.stop).at(stamp)

    def rate(self, stamp: float) -> Vector | None:
        """Return the velocity at a time [s] in the world, shape (3,); None at rest."""
        if stamp >= self.end:
            return None
        return (self.follow if stamp < self.stop.start else self.stop).rate(stamp)


def _turned(velocity: Vector, yaw: float) -> Vector:
    """Return x, y and yaw with x and y turned about the vertical [rad]."""
    c, s = float(np.cos(yaw)), float(np.sin(yaw))
    x, y, turn = (float(value) for value in velocity)
    return np.array([c * x - s * y, s * x + c * y, turn])
