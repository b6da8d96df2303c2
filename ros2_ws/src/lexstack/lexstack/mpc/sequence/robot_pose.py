"""Where a robot is now, in the coordinates of each kind of task."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError
from lexstack.mpc.measures import Subject, joint_indices
from lexstack.robots import Pose, RobotModel
from lexstack.robots.assembly import TOOL
from lexstack.robots.spatial import from_quaternions, log3, to_quaternion, wrap
from lexstack.types import Vector


@dataclass(frozen=True, slots=True, eq=False)
class RobotPose:
    """A robot at one time.

    Attributes:
        stamp: s.
        base: x [m], y [m], yaw [rad], shape (3,), world frame.
        tool: pose of the tool, world frame.
        robot: for other frames and for joints; None: there are none.
        q: its configuration, shape (n_q,).
    """

    stamp: float
    base: Vector
    tool: Pose
    robot: RobotModel | None = None
    q: Vector | None = None

    @classmethod
    def of(cls, robot: RobotModel, stamp: float, q: Vector) -> RobotPose:
        """Return where a robot is at the measured q, shape (n_q,)."""
        return cls(stamp, robot.base_pose(q), robot.tool(q)[0], robot, q)

    def frame(self, name: str) -> Pose:
        """Return the pose of a frame; raises ModelError for an unknown one."""
        if name == TOOL:
            return self.tool
        robot, q = self._whole(f"frame {name!r}")
        return robot.at(q, robot.frame(name))[0]

    def value(self, subject: Subject) -> Vector:
        """Return the present point in the coordinates of a task's reference, shape (r,)."""
        kind = subject.kind
        if kind == "base_position":
            return np.array(self.base[:2])
        if kind == "base_pose":
            return np.array(self.base)
        if kind == "joint_positions":
            robot, q = self._whole("joints")
            return np.asarray(q[joint_indices(subject, robot)])
        pose = self.frame(subject.frame)
        if kind == "ee_position":
            return np.array(pose.position)
        quaternion = to_quaternion(pose.rotation)
        if kind == "ee_orientation":
            return quaternion
        return np.concatenate((pose.position, quaternion))

    def errors(self, subject: Subject, goal: Vector) -> tuple[float, float]:
        """Return how far a goal is: distance [m] and angle [rad], 0 where a kind has none.

        Of joints those of the one that is farthest off, of each sort.
        """
        kind = subject.kind
        if kind.startswith("base"):
            angle = abs(wrap(float(self.base[2] - goal[2]))) if kind == "base_pose" else 0.0
            return float(np.linalg.norm(self.base[:2] - goal[:2])), angle
        if kind == "joint_positions":
            off, slides = np.abs(self.value(subject) - goal), self.slides(subject)
            return float(off[slides].max(initial=0.0)), float(off[~slides].max(initial=0.0))
        pose = self.frame(subject.frame)
        distance = 0.0
        if kind != "ee_orientation":
            distance = float(np.linalg.norm(pose.position - goal[:3]))
        if kind == "ee_position":
            return distance, 0.0
        desired = from_quaternions(goal[None, -4:])[0]
        return distance, float(np.linalg.norm(log3(pose.rotation.T @ desired)))

    def slides(self, subject: Subject) -> NDArray[np.bool_]:
        """Return whether each joint of a task slides, shape (s,)."""
        robot, _ = self._whole("joints")
        return np.asarray(np.array(robot.sliding, dtype=bool)[joint_indices(subject, robot)])

    def _whole(self, what: str) -> tuple[RobotModel, Vector]:
        """Return robot and configuration; raises InputError for a pose that has neither."""
        if self.robot is None or self.q is None:
            raise InputError(f"pose at {self.stamp:g} s: {what}: only base and tool are known")
        return self.robot, self.q
