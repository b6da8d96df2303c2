"""How references of each kind are compared, moved, and how fast they move."""

from __future__ import annotations

import math
from typing import Protocol, TypeVar

import numpy as np
import pinocchio as pin

from lexstack.robots import Pose
from lexstack.robots.spatial import log3, wrap
from lexstack.types import Vector

T = TypeVar("T")


class Space(Protocol[T]):
    """What a way between references needs of their kind."""

    def gap(self, goal: T, value: T) -> Vector:
        """Return ``value`` as seen from ``goal``."""
        ...

    def moved(self, goal: T, gap: Vector) -> T:
        """Return what is a gap away from ``goal``: the inverse of ``gap``."""
        ...

    def velocity(self, goal: T, rate: Vector, gap: Vector, gap_rate: Vector) -> Vector:
        """Return the velocity of ``moved(goal, gap)``, given those of the goal and of the gap."""
        ...

    def nearest(self, gap: Vector, other: Vector) -> Vector:
        """Return a gap with its angles in the turn that is nearest to another gap's.

        A rotation by nearly pi has two vectors, a yaw of nearly pi two signs: a difference between
        them would be taken for a speed.
        """
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

    def velocity(self, goal: Pose, rate: Vector, gap: Vector, gap_rate: Vector) -> Vector:
        """Return the twist in the world, shape (6,): w = w_goal + R_goal J_l(gap) gap'."""
        left = np.asarray(pin.Jexp3(gap[3:])).T  # J_l = J_r^T
        turning = goal.rotation @ (left @ gap_rate[3:])
        return rate + np.concatenate((gap_rate[:3], turning))

    def nearest(self, gap: Vector, other: Vector) -> Vector:
        """Return the gap with the one of its two rotation vectors that is nearer to the other."""
        turn = gap[3:]
        angle = math.sqrt(float(turn @ turn))
        if angle and float(np.abs(turn - other[3:]).max()) > math.pi:
            turn = turn * (1.0 - 2.0 * math.pi / angle)
        return np.concatenate((gap[:3], turn))


class Joints:
    """Positions of joints, or whatever is a plain vector."""

    def gap(self, goal: Vector, value: Vector) -> Vector:
        """Return the difference, shape (m,)."""
        return np.asarray(value - goal)

    def moved(self, goal: Vector, gap: Vector) -> Vector:
        """Return the sum, shape (m,)."""
        return np.asarray(goal + gap)

    def velocity(self, goal: Vector, rate: Vector, gap: Vector, gap_rate: Vector) -> Vector:
        """Return the sum of the velocities, shape (m,)."""
        return np.asarray(rate + gap_rate)

    def nearest(self, gap: Vector, other: Vector) -> Vector:
        """Return the gap."""
        return gap


class Bases(Joints):
    """Planar poses x, y [m], yaw [rad]; the gap takes the short way round."""

    def gap(self, goal: Vector, value: Vector) -> Vector:
        """Return the difference, its yaw in (-pi, pi], shape (3,)."""
        x, y, yaw = (float(one) for one in value - goal)
        return np.array([x, y, wrap(yaw)])

    def nearest(self, gap: Vector, other: Vector) -> Vector:
        """Return the gap with its yaw within half a turn of the other's."""
        return np.array([gap[0], gap[1], other[2] + wrap(float(gap[2] - other[2]))])


POSES = Poses()
"""How references of frames are compared and led in."""
BASES = Bases()
"""How references of bases are compared and led in."""
JOINTS = Joints()
"""How references of postures are compared and led in."""
