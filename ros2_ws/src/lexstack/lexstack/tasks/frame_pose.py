"""End-effector pose by closed-loop inverse kinematics, T(16) to T(20)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.compiled import kernel
from lexstack.options import Positive, build
from lexstack.references import References
from lexstack.robots import Kinematics, Pose, Team
from lexstack.robots.spatial import log3
from lexstack.tasks.feed_forward import feed_forward
from lexstack.types import Curve, LinearTask, Vector

_KERNEL = "lexstack.tasks.kernel.pose"


@dataclass(frozen=True, slots=True)
class EePoseParameters:
    """Parameters of the task ``ee_pose``."""

    gain: Positive = 3.0  # K_p [1/s]
    max_linear: Positive = 0.5  # m/s, saturation of |K_p e| of the position
    max_angular: Positive = 1.0  # rad/s, saturation of |K_p e| of the orientation


class EePose:
    """J chi -> x_dot^d + sat(K_p e), with the measured pose: e = (p_d - p, R log3(R^T R_d))."""

    def __init__(self, team: Team, robot: int, parameters: EePoseParameters) -> None:
        """Make the task of the robot at place ``robot`` of the team."""
        self.name = f"{team.names[robot]}/ee_pose"
        self.robots = (robot,)
        self._robot = robot
        self._columns = team.slices[robot]
        self._n = team.n
        self._team = team
        limits = (parameters.max_linear, parameters.max_angular)
        self._numbers = (parameters.gain, *limits)
        self._curve = Curve(parameters.gain, (robot,), (self._columns,), (1.0,), limits)

    @classmethod
    def from_config(cls, team: Team, robot: int, parameters: dict[str, Any], where: str) -> EePose:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(EePoseParameters, parameters, where))

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 6 rows, m/s then rad/s, in the world frame."""
        robot, start = self._robot, self._columns.start
        tool, goal = kinematics.tools[robot], references.ee[robot]
        matrix, target = np.zeros((6, self._n)), np.empty(6)
        fast, jacobian = kernel(_KERNEL), kinematics.jacobians[robot]
        poses = (tool.position, tool.rotation, goal.position, goal.rotation)
        try:
            done = fast and fast.follow(*poses, *self._numbers, jacobian, start, matrix, target)
        except TypeError:  # a goal in whole numbers
            done = False
        if not done:
            gain, linear, angular = self._numbers
            error = _pose_error(tool, goal)
            target[:3] = saturated(gain * error[:3], linear)
            target[3:] = saturated(gain * error[3:], angular)
            matrix[:, self._columns] = jacobian
        feed = references.twist(self._robot)
        if feed is not None:
            feed = feed_forward(feed, kinematics, self._team, self._robot)
        return LinearTask.equality(self.name, matrix, target, self._curve, feed)


def pose_error(actual: Pose, desired: Pose) -> Vector:
    """Return (p_d - p [m], R log3(R^T R_d) [rad]) in the world frame, shape (6,)."""
    fast, error = kernel(_KERNEL), np.empty(6)
    poses = (actual.position, actual.rotation, desired.position, desired.rotation)
    try:
        done = fast and fast.pose_error(*poses, error)
    except TypeError:  # a goal in whole numbers
        done = False
    return error if done else _pose_error(actual, desired)


def _pose_error(actual: Pose, desired: Pose) -> Vector:
    """Return what ``pose_error`` does, by numpy."""
    error = np.empty(6)
    error[:3] = desired.position - actual.position
    error[3:] = actual.rotation.dot(log3(actual.rotation.T.dot(desired.rotation)))
    return error


def saturated(vector: Vector, limit: float) -> Vector:
    """Return the vector v, shortened to v / sqrt(1 + |v|^2 / limit^2), shorter than ``limit``.

    A plain cut would bend sharply where it ends: a jump of gain x limit in acceleration.
    """
    return vector / math.sqrt(1.0 + float(vector.dot(vector)) / (limit * limit))
