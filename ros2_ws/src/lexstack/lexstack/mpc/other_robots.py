"""The other robots in the way of one: where they will be over its horizon.

One that follows a plan of its own will be where that says. Of one that follows its stack nothing is
known but its velocity: it is taken to brake, each joint as hard as its acceleration limit allows,

    q(t) = q + v s - sign(v) a s^2 / 2,    s = min(t, |v| / a),

so it is where it can be at the earliest, and never beyond where it can stop. At rest it stays.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lexstack.mpc.collision_cost import CollisionScene
from lexstack.mpc.plan import Plan
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, slots=True, eq=False)
class OtherRobot:
    """Another robot at one time.

    Attributes:
        robot: its model.
        q: where it is, shape (n_q,), world frame.
        v: how fast it moves, shape (n,), m/s and rad/s.
        plan: that it follows; None: it follows its stack.
    """

    robot: RobotModel
    q: Vector
    v: Vector
    plan: Plan | None = None

    def configurations(self, stamp: float, times: Vector) -> Matrix:
        """Return where it will be.

        Args:
            stamp: the time at which it is at ``q`` [s].
            times: later ones, increasing, shape (k,), s.

        Returns:
            q at these times, shape (k, n_q). After its plan has ended it stays where that ends.
        """
        if self.plan is not None and stamp < self.plan.end:
            return self.plan.configurations(times)
        return braking(self.robot, self.q, self.v, times - stamp)


def braking(robot: RobotModel, q: Vector, v: Vector, ahead: Vector) -> Matrix:
    """Return q while all joints brake as hard as they may, shape (k, n_q).

    Args:
        robot: its model.
        q: where it is, shape (n_q,).
        v: how fast it moves, shape (n,).
        ahead: times from now, increasing from above 0, shape (k,), s.
    """
    limit = robot.limits.acceleration
    moving = np.minimum(ahead[:, None], np.abs(v) / limit)
    way = moving * (v - 0.5 * np.sign(v) * limit * moving)
    places, at = [], q
    for step, duration in zip(
        np.diff(way, axis=0, prepend=np.zeros((1, len(v)))),
        np.diff(ahead, prepend=0.0),
        strict=True,
    ):
        at = robot.integrate(at, step / duration, float(duration))
        places.append(at)
    return np.array(places)


def scene_of(others: Iterable[OtherRobot], stamp: float, times: Vector) -> CollisionScene | None:
    """Return the spheres of other robots at times (k,) [s]; None: there are none."""
    centers, radii = [], []
    for other in others:
        model = other.robot.spheres
        if len(model.radii):
            places = other.configurations(stamp, times)
            centers.append(np.array([model.at(q)[0].T for q in places]))
            radii.append(model.radii)
    if not centers:
        return None
    return CollisionScene(np.concatenate(centers, axis=1), np.concatenate(radii))
