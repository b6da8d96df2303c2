"""End-effector pose by closed-loop inverse kinematics, T(16) to T(20)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.options import Positive, build
from lexstack.references import References
from lexstack.robots import Kinematics, Pose, Team
from lexstack.robots.spatial import log3
from lexstack.tasks.feed_forward import feed_forward
from lexstack.types import Curve, LinearTask, Vector


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
        self._parameters = parameters
        limits = (parameters.max_linear, parameters.max_angular)
        self._curve = Curve(parameters.gain, (robot,), (self._columns,), (1.0,), limits)

    @classmethod
    def from_config(cls, team: Team, robot: int, parameters: dict[str, Any], where: str) -> EePose:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(EePoseParameters, parameters, where))

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 6 rows, m/s then rad/s, in the world frame."""
        error = pose_error(kinematics.tools[self._robot], references.ee[self._robot])
        gain = self._parameters.gain
        target = np.empty(6)
        target[:3] = saturated(gain * error[:3], self._parameters.max_linear)
        target[3:] = saturated(gain * error[3:], self._parameters.max_angular)
        matrix = np.zeros((6, self._n))
        matrix[:, self._columns] = kinematics.jacobians[self._robot]
        feed = references.twist(self._robot)
        if feed is not None:
            feed = feed_forward(feed, kinematics, self._team, self._robot)
        return LinearTask.equality(self.name, matrix, target, self._curve, feed)


def pose_error(actual: Pose, desired: Pose) -> Vector:
    """Return (p_d - p [m], R log3(R^T R_d) [rad]) in the world frame, shape (6,)."""
    error = np.empty(6)
    error[:3] = desired.position - actual.position
    error[3:] = actual.rotation.dot(log3(actual.rotation.T.dot(desired.rotation)))
    return error


def saturated(vector: Vector, limit: float) -> Vector:
    """Return the vector v, shortened to v / sqrt(1 + |v|^2 / limit^2), shorter than ``limit``.

    A plain cut would bend sharply where it ends: a jump of gain x limit in acceleration.
    """
    return vector / math.sqrt(1.0 + float(vector.dot(vector)) / (limit * limit))
