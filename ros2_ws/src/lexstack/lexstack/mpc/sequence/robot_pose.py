"""Where a robot is now, in the coordinates of each kind of task."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.mpc.tracking_objectives import Kind
from lexstack.robots import Pose, RobotModel
from lexstack.robots.spatial import from_quaternions, log3, to_quaternion, wrap
from lexstack.types import Vector


@dataclass(frozen=True, slots=True, eq=False)
class RobotPose:
    """A robot at one time.

    Attributes:
        stamp: s.
        base: x [m], y [m], yaw [rad], shape (3,), world frame.
        tool: pose of the tool, world frame.
    """

    stamp: float
    base: Vector
    tool: Pose

    @classmethod
    def of(cls, robot: RobotModel, stamp: float, q: Vector) -> RobotPose:
        """Return where a robot is at the measured q, shape (n,)."""
        return cls(stamp, robot.base_pose(q), robot.tool(q)[0])

    def value(self, kind: Kind) -> Vector:
        """Return the present point in the coordinates of a kind's reference, shape (r,)."""
        if kind == "base_position":
            return np.array(self.base[:2])
        if kind == "base_pose":
            return np.array(self.base)
        if kind == "ee_position":
            return np.array(self.tool.position)
        return np.concatenate((self.tool.position, to_quaternion(self.tool.rotation)))

    def errors(self, kind: Kind, goal: Vector) -> tuple[float, float]:
        """Return how far a goal is: distance [m] and angle [rad], 0 where a kind has none."""
        if kind.startswith("base"):
            angle = abs(wrap(float(self.base[2] - goal[2]))) if kind == "base_pose" else 0.0
            return float(np.linalg.norm(self.base[:2] - goal[:2])), angle
        distance = float(np.linalg.norm(self.tool.position - goal[:3]))
        if kind == "ee_position":
            return distance, 0.0
        desired = from_quaternions(goal[None, 3:])[0]
        return distance, float(np.linalg.norm(log3(self.tool.rotation.T @ desired)))
