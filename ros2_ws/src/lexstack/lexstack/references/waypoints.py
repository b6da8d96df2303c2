"""Timed poses: smooth through all of them, at rest before the first and after the last.

Positions are a spline of degree 5, rotations a path with continuous angular velocity and
acceleration (``RotationPath``). Velocities and accelerations can be limited: times that are given
are then checked; where none are given, they are found. Twists at the poses may be given: the way
may then begin in motion, and before its first time it goes straight on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pinocchio as pin

from lexstack.errors import InputError
from lexstack.options import Range
from lexstack.references.rotation_path import RotationPath
from lexstack.references.spline import Spline, checked_rates, checked_times
from lexstack.robots import Pose
from lexstack.robots.spatial import log3
from lexstack.types import Matrix, Vector

_HALF_TURN = math.pi - 1e-3  # rad, between two waypoints: at pi the way round is not known
_SAMPLES = 64  # of each interval, for the largest velocity and acceleration
_OVER = 1.001  # of a limit: between two samples it may be a little more
_SHORTEST = 1e-3  # s, between two waypoints that are the same


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """What a way through poses may need at most."""

    linear_velocity: float = math.inf  # m/s
    linear_acceleration: float = math.inf  # m/s2
    angular_velocity: float = math.inf  # rad/s
    angular_acceleration: float = math.inf  # rad/s2

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a limit that is not positive; inf is none."""
        for name in ("velocity", "acceleration"):
            for kind in ("linear", "angular"):
                value = getattr(self, f"{kind}_{name}")
                if value != math.inf:
                    Range(0.0, open=True).check(value, f"{where}: {kind}_{name}")

    @property
    def values(self) -> Vector:
        """In the order of ``peaks``, shape (4,)."""
        linear = (self.linear_velocity, self.linear_acceleration)
        return np.array([*linear, self.angular_velocity, self.angular_acceleration])


@dataclass(frozen=True, slots=True, eq=False)
class Waypoints:
    """A ``Trajectory`` through poses at times.

    Attributes:
        times: shape (N,), N >= 2, increasing, simulated time [s].
        poses: N of them; the turn between two in a row must be less than half a turn.
        twists: at the poses in the world, shape (N, 6), m/s and rad/s, zero at the end; None: what
            is smooth.
    """

    times: Vector
    poses: tuple[Pose, ...]
    twists: Matrix | None = None
    _positions: Spline = field(init=False, repr=False)
    _rotations: RotationPath = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Find the splines; raises InputError for times or poses that make none."""
        times, poses = checked_times(self.times), tuple(self.poses)
        times.setflags(write=False)
        if len(poses) != len(times):
            raise InputError(f"poses: expected {len(times)}, as many as times, got {len(poses)}")
        for k, (one, other) in enumerate(pairwise(poses), start=1):
            turn = _angle(one, other)
            if turn > _HALF_TURN:
                raise InputError(
                    f"poses[{k}]: turned by {turn:.3f} rad from the one before: "
                    f"at most {_HALF_TURN:.3f}; put one in between"
                )
        twists = checked_rates(self.twists, "twists", (len(times), 6))
        linear, turning = (None, None) if twists is None else (twists[:, :3], twists[:, 3:])
        turns = np.array([pose.rotation for pose in poses])
        rotations = RotationPath.through(times, turns, turning)
        positions = Spline(times, np.array([pose.position for pose in poses]), linear)
        names = ("times", "poses", "twists", "_positions", "_rotations")
        values = (times, poses, twists, positions, rotations)
        for name, value in zip(names, values, strict=True):
            object.__setattr__(self, name, value)

    @property
    def end(self) -> float:
        """The time from which it rests [s]."""
        return float(self.times[-1])

    def at(self, stamp: float) -> Pose:
        """Return the pose at a time [s]; the first one before, the last one after."""
        if stamp >= self.end:
            return self.poses[-1]
        if stamp <= self.times[0]:
            return self._before(stamp)
        return Pose(self._positions.at(stamp), self._rotations.at(stamp))

    def rate(self, stamp: float) -> Vector | None:
        """Return the twist in the world at a time [s], shape (6,); None before and after."""
        if stamp <= self.times[0]:
            return self._first
        linear = self._positions.rate(stamp)
        if linear is None:
            return None
        return np.concatenate((linear, self._rotations.rate(stamp)))

    def _before(self, stamp: float) -> Pose:
        """Return the pose at a time before the first one [s]."""
        first, twist = self.poses[0], self._first
        if twist is None:
            return first
        away = (stamp - float(self.times[0])) * twist
        return Pose(first.position + away[:3], np.asarray(pin.exp3(away[3:]) @ first.rotation))

    @property
    def _first(self) -> Vector | None:
        """The twist with which it begins, shape (6,); None: it begins at rest."""
        return self.twists[0] if self.twists is not None and self.twists[0].any() else None


def timed_waypoints(
    poses: Sequence[Pose],
    times: Sequence[float] | Vector | None = None,
    *,
    start: float = 0.0,
    limits: MotionLimits | None = None,
    twists: Matrix | None = None,
) -> Waypoints:
    """Return the way through poses within limits.

    Args:
        poses: two or more.
        times: simulated time of each [s]; None: the way is as quick as ``limits`` allow, with the
            time between two poses in proportion to what their distance and turn need.
        start: time of the first pose where no times are given [s].
        limits: None: none, and then times must be given.
        twists: at the poses, where times are given; see ``Waypoints``.

    Raises:
        InputError: poses or times that make no way, or a way that is beyond a limit.
        ConfigurationError: a limit is not positive.
    """
    limits = limits or MotionLimits()
    limits.validate("limits")
    if times is not None:
        way = Waypoints(np.asarray(times, dtype=np.float64), tuple(poses), twists)
        beyond = peaks(way) / limits.values
        worst = int(np.argmax(beyond))
        if beyond[worst] > _OVER:
            raise InputError(
                f"times: the way needs {_NAMES[worst]} {beyond[worst] * limits.values[worst]:.3g} "
                f"{_UNITS[worst]}, the limit is {limits.values[worst]:g}"
            )
        return way
    if len(poses) < 2:
        raise InputError(f"poses: expected two or more, got {len(poses)}")
    if np.isinf(limits.values[[0, 2]]).any():
        raise InputError("times: none are given, and linear or angular velocity has no limit")
    spans = np.array([_span(a, b, limits) for a, b in pairwise(poses)])
    relative = np.concatenate(([0.0], np.cumsum(spans)))
    found = peaks(Waypoints(relative, tuple(poses))) / limits.values
    # Of a way that takes k times as long, velocities are 1/k and accelerations 1/k^2 as large.
    longer = float(np.max([found[0], math.sqrt(found[1]), found[2], math.sqrt(found[3])]))
    return Waypoints(start + (longer or 1.0) * relative, tuple(poses))


def peaks(way: Waypoints) -> Vector:
    """Return the largest velocity and acceleration, linear, then angular, shape (4,), SI units."""
    times = np.concatenate(
        [np.linspace(a, b, _SAMPLES, endpoint=False) for a, b in pairwise(way.times)]
    )
    step = 1e-4 * float(np.diff(way.times).min())
    zero = np.zeros(6)
    rates = np.array([_or(way.rate(float(t)), zero) for t in times])
    ahead = np.array([_or(way.rate(float(t) + step), zero) for t in times])
    found = []
    for part in (slice(0, 3), slice(3, 6)):
        found.append(float(np.linalg.norm(rates[:, part], axis=1).max()))
        change = (ahead - rates)[:, part] / step
        found.append(float(np.linalg.norm(change, axis=1).max()))
    return np.array(found)


_NAMES = ("linear velocity", "linear acceleration", "angular velocity", "angular acceleration")
_UNITS = ("m/s", "m/s2", "rad/s", "rad/s2")


def _or(rate: Vector | None, zero: Vector) -> Vector:
    """Return a rate, or zero where there is none."""
    return zero if rate is None else rate


def _angle(one: Pose, other: Pose) -> float:
    """Return the angle between two poses [rad]."""
    return float(np.linalg.norm(log3(one.rotation.T @ other.rotation)))


def _span(one: Pose, other: Pose, limits: MotionLimits) -> float:
    """Return the time from one pose to another at the velocity limits [s]."""
    distance = float(np.linalg.norm(other.position - one.position))
    by_turn = _angle(one, other) / limits.angular_velocity
    return max(distance / limits.linear_velocity, by_turn, _SHORTEST)
