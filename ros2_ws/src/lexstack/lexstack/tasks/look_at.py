"""A frame looks at a point: an axis of it along the line to that point.

With d = (t - p) / |t - p| from the frame's origin p to the point t at the distance r, the axis a,
and e = angle(a, d) (a x d) / |a x d|,

    B (J_w + [d]x J_v / r) chi -> B sat(gain e)

with B two directions across a, shape (2, 3). The second term of the rows is how d turns while the
frame moves. mink: ``LookAtTask``; pink and placo have none, and placo's ``AxisAlignTask``
with a direction of each tick would leave that term out.

How the rows turn (``FrameRows.turning``): with m = B^T e, and the frame's velocities v and w, the
second derivative of half of the squared error has, besides what the chain of joints bends,

    - 2 (d . v) ((m x d) . v) / r^2 - (a . w) ((m x a) . w)

as d turns faster the nearer the frame comes, and a frame that turns about its axis takes B along.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.options import Finite3, Positive, build
from lexstack.references import TOOL, References
from lexstack.robots import Kinematics, Team
from lexstack.robots.options import Vector3
from lexstack.tasks.directions import across, check_direction, turn_between, unit
from lexstack.tasks.frame_pose import saturated
from lexstack.tasks.frame_task import check_frame, task_name
from lexstack.types import Curve, FrameRows, LinearTask, Matrix, Vector


@dataclass(frozen=True, slots=True)
class LookAtParameters:
    """Parameters of the task ``look_at``."""

    point: Finite3  # m, in the world
    frame: str = TOOL  # of the robot: a link or joint of its description
    axis: Vector3 = (0.0, 0.0, 1.0)  # that looks, in the frame; its length does not matter
    gain: Positive = 3.0  # 1/s
    max_angular: Positive = 1.0  # rad/s, saturation of |gain e|
    nearest: Positive = 0.05  # m: nearer to the point it counts as so far away

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        check_direction(where, axis=self.axis)


class LookAt:
    """B (J_w + [d]x J_v / r) chi -> B sat(gain e), with the measured pose."""

    def __init__(self, team: Team, robot: int, parameters: LookAtParameters, where: str) -> None:
        """Make the task of the robot at place ``robot``; raises for a frame that is not there."""
        self.name = task_name(team, robot, "look_at", parameters.frame)
        self.robots = (robot,)
        check_frame(team, robot, parameters.frame, f"{where}: frame")
        self._columns = team.slices[robot]
        self._n = team.n
        self._parameters = parameters
        limits, columns = (parameters.max_angular,), (self._columns,)
        self._curve = Curve(parameters.gain, (robot,), columns, (1.0,), limits, sizes=(2,))
        self._axis, self._point = unit(parameters.axis), np.array(parameters.point)

    @classmethod
    def from_config(cls, team: Team, robot: int, parameters: dict[str, Any], where: str) -> LookAt:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(LookAtParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 2 rows [rad/s], about two directions across the axis."""
        pose, jacobian = kinematics.frame(self.robots[0], self._parameters.frame)
        line = self._point - pose.position
        distance = max(math.sqrt(float(line @ line)), self._parameters.nearest)
        axis, direction = pose.rotation @ self._axis, line / distance
        both = across(axis, pose.rotation)
        length = math.sqrt(float(direction @ direction))
        aim = direction / length if length > 0.0 else axis
        target = both @ turn_between(axis, aim)
        # d turns with d x d_dot = -d x v / r.
        axes = np.hstack((np.cross(both, direction) / distance, both))
        matrix = np.zeros((2, self._n))
        matrix[:, self._columns] = axes @ jacobian
        target = saturated(self._parameters.gain * target, self._parameters.max_angular)
        rows = FrameRows(axes, jacobian, turning=_turning(both, axis, direction, distance))
        return LinearTask.equality(self.name, matrix, target, self._curve, frame=rows)


def _turning(both: Matrix, axis: Vector, direction: Vector, distance: float) -> NDArray[np.float64]:
    """Return Q of each row, shape (2, 6, 6)."""
    found = np.zeros((2, 6, 6))
    nearing = np.cross(both, direction)[:, :, None] * (direction / (distance * distance))
    spinning = np.cross(both, axis)[:, :, None] * (0.5 * axis)
    found[:, :3, :3] = -nearing - nearing.transpose(0, 2, 1)
    found[:, 3:, 3:] = -spinning - spinning.transpose(0, 2, 1)
    return found
