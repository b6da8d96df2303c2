"""Velocity of a frame within limits, axis by axis: an inequality.

    -limit <= A J chi <= limit

with A as in ``frame_task``. An axis whose limit is infinite has no row. Like every inequality it is
kept exactly where the levels above and the joints' limits allow it. pink, mink and placo limit the
velocities of joints alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import Range, build
from lexstack.references import TOOL, References
from lexstack.robots import Kinematics, Team
from lexstack.robots.options import Vector3
from lexstack.tasks.frame_task import LOCAL, WORLD, check_frame, task_name
from lexstack.types import LinearTask


@dataclass(frozen=True, slots=True)
class FrameVelocityLimitParameters:
    """Parameters of the task ``frame_velocity_limit``."""

    frame: str = TOOL  # of the robot: a link or joint of its description
    axes: str = WORLD  # of the limits: world, local, or another frame of the robot
    linear: Vector3 = (0.25, 0.25, 0.25)  # m/s, along x, y, z; .inf: no limit
    angular: Vector3 = (math.inf, math.inf, math.inf)  # rad/s, about x, y, z; .inf: no limit

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a limit that is not positive, or where there is none."""
        for name in ("linear", "angular"):
            for i, value in enumerate(getattr(self, name)):
                if value != math.inf:
                    Range(0.0, open=True).check(value, f"{where}: {name}[{i}]")
        if math.inf == min(*self.linear, *self.angular):
            raise ConfigurationError(f"{where}: linear: no limit is given, nor in angular")


class FrameVelocityLimit:
    """-limit <= A J chi <= limit."""

    def __init__(
        self, team: Team, robot: int, parameters: FrameVelocityLimitParameters, where: str
    ) -> None:
        """Make the task of the robot at place ``robot``; raises for a frame that is not there."""
        self.name = task_name(team, robot, "frame_velocity_limit", parameters.frame)
        self.robots = (robot,)
        check_frame(team, robot, parameters.frame, f"{where}: frame")
        if parameters.axes not in (WORLD, LOCAL):
            check_frame(team, robot, parameters.axes, f"{where}: axes")
        self._columns = team.slices[robot]
        self._n = team.n
        self._parameters = parameters
        limits = np.array([*parameters.linear, *parameters.angular])
        self._kept = np.isfinite(limits)
        self._upper, self._lower = limits[self._kept], -limits[self._kept]

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> FrameVelocityLimit:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(FrameVelocityLimitParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return a row for each axis with a limit, m/s and rad/s."""
        (robot,), p = self.robots, self._parameters
        pose, jacobian = kinematics.frame(robot, p.frame)
        if p.axes != WORLD:
            turn = pose if p.axes == LOCAL else kinematics.frame(robot, p.axes)[0]
            back = turn.rotation.T
            jacobian = np.concatenate((back @ jacobian[:3], back @ jacobian[3:]))
        matrix = np.zeros((len(self._upper), self._n))
        matrix[:, self._columns] = jacobian[self._kept]
        return LinearTask(self.name, matrix, self._lower, self._upper)
