"""An axis of a frame along a direction: the turn about that axis stays free.

With a the axis in the world, d the direction, and the error that turns a into d the short way,

    e = angle(a, d) (a x d) / |a x d|        B (J_w chi) -> B sat(gain e)

with B two directions across a, shape (2, 3). mink and placo: ``AxisAlignTask``; pink has no such
task.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.options import Positive, build
from lexstack.references import TOOL, References
from lexstack.robots import Kinematics, Team
from lexstack.robots.options import Vector3
from lexstack.tasks.directions import across, check_direction, turn_between, unit
from lexstack.tasks.frame_pose import saturated
from lexstack.tasks.frame_task import check_frame, task_name
from lexstack.types import Curve, FrameRows, LinearTask


@dataclass(frozen=True, slots=True)
class AxisAlignmentParameters:
    """Parameters of the task ``axis_alignment``."""

    frame: str = TOOL  # of the robot: a link or joint of its description
    axis: Vector3 = (0.0, 0.0, 1.0)  # in the frame; its length does not matter
    direction: Vector3 = (0.0, 0.0, -1.0)  # in the world; its length does not matter
    gain: Positive = 3.0  # 1/s
    max_angular: Positive = 1.0  # rad/s, saturation of |gain e|

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        check_direction(where, axis=self.axis, direction=self.direction)


class AxisAlignment:
    """B J_w chi -> B sat(gain e), with the measured axis."""

    def __init__(
        self, team: Team, robot: int, parameters: AxisAlignmentParameters, where: str
    ) -> None:
        """Make the task of the robot at place ``robot``; raises for a frame that is not there."""
        self.name = task_name(team, robot, "axis_alignment", parameters.frame)
        self.robots = (robot,)
        check_frame(team, robot, parameters.frame, f"{where}: frame")
        self._columns = team.slices[robot]
        self._n = team.n
        self._parameters = parameters
        self._axis, self._direction = unit(parameters.axis), unit(parameters.direction)
        limits = (parameters.max_angular,)
        self._curve = Curve(parameters.gain, (robot,), (self._columns,), (1.0,), limits, sizes=(2,))

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> AxisAlignment:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(AxisAlignmentParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 2 rows [rad/s], about two directions across the axis."""
        pose, jacobian = kinematics.frame(self.robots[0], self._parameters.frame)
        axis = pose.rotation @ self._axis
        axes = np.zeros((2, 6))
        axes[:, 3:] = across(axis, pose.rotation)
        error = axes[:, 3:] @ turn_between(axis, self._direction)
        target = saturated(self._parameters.gain * error, self._parameters.max_angular)
        matrix = np.zeros((2, self._n))
        matrix[:, self._columns] = axes @ jacobian
        rows = FrameRows(axes, jacobian)
        return LinearTask.equality(self.name, matrix, target, self._curve, frame=rows)
