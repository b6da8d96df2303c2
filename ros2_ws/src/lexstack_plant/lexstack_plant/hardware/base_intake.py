"""The measured pose and velocity of one platform: any odometry frame, any axes of the twist.

Both come in one message of odometry; or poses come from /tf, and velocities from odometry or from
the poses' differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, hypot, pi, remainder
from typing import NoReturn

import numpy as np

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.types import Vector
from lexstack_plant.hardware.joint_intake import IntakeCounters
from lexstack_plant.hardware.planar import composed, inverse, turned
from lexstack_plant.hardware.stamps import Stamps

_SMOOTHING = 0.02  # s, of velocities that follow from poses
_PLAUSIBLE = 1.5  # times the velocity limit: what two poses may differ by
_FLAT = 0.2  # rad: a platform that is tilted by more does not stand on its wheels
_UNIT = 1e-2  # how far a quaternion's norm may be from 1
_FARTHEST = 1e5  # m
_SHORTEST = 1e-5  # s between two samples


@dataclass(frozen=True, slots=True)
class BaseSample:
    """One message of a platform, as it came.

    Attributes:
        x: m, in the frame of the odometry.
        y: m.
        quaternion: x, y, z, w.
        twist: along x and y [m/s], about z [rad/s]; or none.
        stamp: s by the sender's clock; 0: none.
        received: s by the local clock.
        frame: in which the pose is.
    """

    x: float
    y: float
    quaternion: Sequence[float]
    twist: Sequence[float] | None
    stamp: float
    received: float
    frame: str = ""


class BaseIntake:
    """Pose and velocity of a platform in the world; the yaw is unwrapped.

    Attributes:
        q: x [m], y [m], yaw [rad] in the world, shape (3,); NaN until it is known.
        v: m/s, m/s, rad/s along the world's axes, shape (3,).
        time: when it was measured, by the local clock [s]; -inf: never.
        fault: why the last pose, or its time, cannot be true; empty: they can. It stays until
            ``forget``.
        counters: of messages.
        twisted: when the velocity was measured, as ``time``, where odometry tells it alone.
    """

    def __init__(
        self,
        velocity: Vector,
        tolerance: float,
        *,
        origin: Sequence[float] | None = None,
        frame: str = "",
        twist_in_base: bool = True,
        shared: bool = False,
        twist_apart: bool = False,
    ) -> None:
        """Make the intake of a platform.

        Args:
            velocity: limits along x, y, yaw, shape (3,).
            tolerance: by which a pose may jump beyond what the limits allow [m, rad].
            origin: x, y, yaw of the odometry's frame in the world; None: ``place`` says it.
            frame: that messages of odometry must name; empty: any.
            twist_in_base: whether twists are along the axes of the base.
            shared: whether stamps are of the local clock.
            twist_apart: whether velocities come by ``hear_twist``.
        """
        self.q: Vector = np.full(3, np.nan)
        self.v: Vector = np.zeros(3)
        self.time = -np.inf
        self.fault = ""
        self.counters = IntakeCounters()
        self.placed = origin is not None
        self._origin: Vector = np.zeros(3) if origin is None else np.array(origin, dtype=float)
        self._velocity = velocity
        self._tolerance = tolerance
        self._frame = frame
        self._twist_in_base = twist_in_base
        self._poses, self._twists = Stamps(shared=shared), Stamps(shared=shared)
        self._twist_apart = twist_apart
        self.twisted = -np.inf if twist_apart else np.inf

    def hear(self, sample: BaseSample) -> None:
        """Take a message; raises InputError for one that is no pose of a platform."""
        yaw = self._checked(sample)
        restarted = self._poses.restarted(sample.stamp)
        time = self._poses.time(sample.stamp, sample.received, self.counters)
        if time is None:
            return
        self.counters.taken += 1
        first = not np.isfinite(self.q[0])
        pose = composed(self._origin, (sample.x, sample.y, yaw))
        if not first:
            # Of all angles that are this one, the nearest to where it was: it is never modulo 2 pi.
            pose[2] = self.q[2] + remainder(pose[2] - self.q[2], 2.0 * pi)
        elapsed = max(time - self.time, _SHORTEST)
        moved = np.zeros(3) if first else pose - self.q
        self._check(moved, elapsed)
        self.fault = restarted or self.fault
        self.q, self.time = pose, time
        if self._twist_apart:
            return
        if sample.twist is None:
            share = 0.0 if first else elapsed / (elapsed + _SMOOTHING)
            self.v += share * (moved / elapsed - self.v)
        else:
            self._turn(sample.twist)

    def hear_twist(self, sample: BaseSample) -> None:
        """Take the velocity of a message whose pose does not count; raises InputError as ``hear``.

        It is taken once a pose is known, along whose yaw it is.
        """
        self._check_numbers(sample.twist or ())
        self._check_frame(sample)
        self.fault = self._twists.restarted(sample.stamp) or self.fault
        time = self._twists.time(sample.stamp, sample.received, self.counters)
        if time is None or sample.twist is None or not np.isfinite(self.q[0]):
            return
        self._turn(sample.twist)
        self.twisted = time

    def place(self, world: Sequence[float]) -> None:
        """Say that the platform is at x, y, yaw of the world now, unless its frame was placed."""
        if self.placed:
            return
        # origin = world * measured^-1, so that origin * measured is the world's pose.
        measured = composed(inverse(self._origin), self.q)
        self._origin = composed(world, inverse(measured))
        self.q = composed(self._origin, measured)
        self.v = turned(self.v, float(self.q[2]) - float(measured[2]))
        self.placed = True

    def at(self, now: float, most: float) -> Vector:
        """Return where the platform is now, shape (3,): it went on for ``most`` [s] at most."""
        return self.q + self.v * min(max(now - self.time, 0.0), most)

    def age(self, now: float) -> float:
        """Return how old pose and velocity are [s]; inf: one is not known."""
        return float(now - min(self.time, self.twisted))

    def forget(self) -> None:
        """Take the next poses as the truth, whatever was before."""
        self.fault = ""

    def _turn(self, twist: Sequence[float]) -> None:
        """Take a twist, by the axes that it is in."""
        turn = self.q[2] if self._twist_in_base else self._origin[2]
        self.v = turned(np.array(twist, dtype=np.float64), float(turn))

    def _check_numbers(self, numbers: Sequence[float]) -> None:
        """Raise InputError unless all are numbers."""
        if not np.isfinite(numbers).all():
            self._refuse(f"not a number in {list(numbers)}")

    def _check_frame(self, sample: BaseSample) -> None:
        """Raise InputError for a message of odometry in another frame than it must be."""
        if self._frame and sample.frame.lstrip("/") != self._frame.lstrip("/"):
            self._refuse(f"frame {shown(sample.frame)}, expected {shown(self._frame)}")

    def _checked(self, sample: BaseSample) -> float:
        """Return the yaw of a message; raises InputError where it is no pose of a platform."""
        self._check_numbers([sample.x, sample.y, *sample.quaternion, *(sample.twist or ())])
        if max(abs(sample.x), abs(sample.y)) > _FARTHEST:
            self._refuse(f"at {sample.x:g}, {sample.y:g} m")
        if not self._twist_apart:
            self._check_frame(sample)
        x, y, z, w = sample.quaternion
        norm = hypot(x, y, z, w)
        if abs(norm - 1.0) > _UNIT:
            self._refuse(f"orientation: norm {norm:.4f}, must be 1")
        tilt = 2.0 * atan2(hypot(x, y), hypot(z, w))
        if tilt > _FLAT:
            self._refuse(f"tilted by {tilt:.2f} rad")
        return 2.0 * atan2(z, w)

    def _refuse(self, what: str) -> NoReturn:
        """Count a message that is no pose, and raise InputError."""
        self.counters.refused += 1
        raise InputError(f"the base's pose: {what}")

    def _check(self, moved: Vector, elapsed: float) -> None:
        """Set ``fault`` if the platform moved by more than its limits allow."""
        most = _PLAUSIBLE * float(self._velocity[:2].max()) * elapsed + self._tolerance
        far = hypot(moved[0], moved[1])
        if far > most:
            self.fault = f"the base jumped by {far:.3g} m in {1e3 * elapsed:.1f} ms"
        turn = abs(float(moved[2]))
        if turn > _PLAUSIBLE * self._velocity[2] * elapsed + self._tolerance:
            self.fault = f"the base turned by {turn:.3g} rad in {1e3 * elapsed:.1f} ms"
