"""A stream of twists, as of a joystick: each one is followed until the next comes, or it is late.

From the velocity before to the new one leads a ramp with the share s = t / T:

    p(t) = p_0 + v_0 a(t) + v_1 b(t)        R(t) = exp(w_1 b(t)) exp(w_0 a(t)) R_0
    a' = 1 - s, b' = s

so that velocities are continuous: w = w_1 b' + exp(w_1 b) w_0 a'. If no further twist comes within
a stated time, a ramp to zero follows. T is such that the ramp is within the acceleration limits;
while the axis of rotation changes, the angular acceleration may be larger by |w_0 x w_1| / 4, and
by what the turn of the ramp itself does to w_0. A ramp whose acceleration were continuous too would
begin at rest with every twist: a quick stream would hardly move the frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from lexstack.errors import InputError
from lexstack.references.trajectory import Trajectory
from lexstack.robots import Pose
from lexstack.types import Vector

_SHORTEST = 1e-3  # s, of a ramp


@dataclass(frozen=True, slots=True)
class Twist:
    """A velocity that is asked of a frame until the next one comes.

    Attributes:
        value: velocity of its origin [m/s] and angular velocity [rad/s] in the world, shape (6,).
        timeout: after so long without another one the frame comes to rest [s].
        linear: largest linear acceleration of the reference [m/s2].
        angular: largest angular acceleration of the reference [rad/s2].
    """

    value: Vector
    timeout: float = 0.2
    linear: float = 1.0
    angular: float = 2.0

    def __post_init__(self) -> None:
        """Raise InputError for a value out of range."""
        value = np.array(self.value, dtype=np.float64)
        if value.shape != (6,) or not np.isfinite(value).all():
            raise InputError(f"twist: expected 6 finite numbers, got shape {value.shape}")
        for name in ("timeout", "linear", "angular"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InputError(f"twist: {name}: must be finite and > 0")
        value.setflags(write=False)
        object.__setattr__(self, "value", value)


@dataclass(frozen=True, slots=True, eq=False)
class Ramp:
    """From one twist to another, which then stays.

    Attributes:
        start: time of the beginning [s].
        pose: at the beginning.
        before: twist at the beginning, shape (6,), m/s and rad/s, world frame.
        after: twist from the end on, shape (6,).
        duration: T [s], positive.
    """

    start: float
    pose: Pose
    before: Vector
    after: Vector
    duration: float

    @classmethod
    def between(cls, start: float, pose: Pose, before: Vector, twist: Twist, after: Vector) -> Ramp:
        """Return the shortest ramp within the acceleration limits of a twist."""
        change = after - before
        linear = float(np.linalg.norm(change[:3])) / twist.linear
        angular = float(np.linalg.norm(change[3:])) / twist.angular
        duration = max(linear, angular, _SHORTEST)
        return cls(start, pose, before, after, duration)

    def at(self, stamp: float) -> Pose:
        """Return the pose at a time [s], not before the start."""
        a, b, _ = self._shares(stamp)
        turn = pin.exp3(b * self.after[3:]) @ pin.exp3(a * self.before[3:])
        position = self.pose.position + a * self.before[:3] + b * self.after[:3]
        return Pose(position, np.asarray(turn @ self.pose.rotation))

    def rate(self, stamp: float) -> Vector:
        """Return the twist at a time [s], not before the start, shape (6,)."""
        _, b, share = self._shares(stamp)
        rate = share * self.after + (1.0 - share) * self.before
        if share < 1.0:
            turned = np.asarray(pin.exp3(b * self.after[3:])) @ self.before[3:]
            rate[3:] = share * self.after[3:] + (1.0 - share) * turned
        return rate

    def _shares(self, stamp: float) -> tuple[float, float, float]:
        """Return a [s], b [s] and s at a time."""
        elapsed = stamp - self.start
        x = min(max(elapsed / self.duration, 0.0), 1.0)
        risen = 0.5 * self.duration * x * x  # the integral of s
        beyond = max(elapsed - self.duration, 0.0)
        return self.duration * x - risen, risen + beyond, x


@dataclass(frozen=True, slots=True, eq=False)
class TwistStream:
    """A ``Trajectory``: a twist that is followed, and rest where no other one comes in time.

    Attributes:
        twist: that is asked for.
        follow: the ramp to it.
        stop: the ramp to rest.
        goal: the pose at rest.
    """

    twist: Twist
    follow: Ramp
    stop: Ramp
    goal: Pose

    @classmethod
    def begun(cls, motion: Trajectory[Pose], stamp: float, twist: Twist) -> TwistStream:
        """Return the stream that goes on from any reference at a time [s].

        A reference whose velocity is not added to what tasks ask for, as a set-point that is led
        in, counts as one at rest.
        """
        rate = motion.rate(stamp)
        before = np.zeros(6) if rate is None else rate
        return cls.along(Ramp.between(stamp, motion.at(stamp), before, twist, twist.value), twist)

    @classmethod
    def along(cls, follow: Ramp, twist: Twist) -> TwistStream:
        """Return the stream whose ramp to its twist is known."""
        late = follow.start + twist.timeout
        stop = Ramp.between(late, follow.at(late), follow.rate(late), twist, np.zeros(6))
        return cls(twist, follow, stop, stop.at(stop.start + stop.duration))

    @property
    def end(self) -> float:
        """The time at which it has come to rest [s]."""
        return self.stop.start + self.stop.duration

    def at(self, stamp: float) -> Pose:
        """Return the pose at a time [s]."""
        if stamp >= self.end:
            return self.goal
        return (self.follow if stamp < self.stop.start else self.stop).at(stamp)

    def rate(self, stamp: float) -> Vector | None:
        """Return the twist at a time [s], shape (6,); None at rest."""
        if stamp >= self.end:
            return None
        return (self.follow if stamp < self.stop.start else self.stop).rate(stamp)
