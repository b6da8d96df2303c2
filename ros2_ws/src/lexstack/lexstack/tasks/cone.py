"""An axis of a frame within a cone: an inequality on the speed at which it nears the edge.

With the axis a, the direction d, and the angle theta between them, the row

    (d x a) / |d x a| . (J_w chi) <= w(angle - theta)

with w(r) the largest speed of approach from which the axis can still stop, see
``collision_avoidance``. Where a and d are one, the axis is free in all directions and the row is
open. placo: ``ConeConstraint``; pink and mink have none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from lexstack.options import Range, build
from lexstack.references import TOOL, References
from lexstack.robots import Kinematics, Team
from lexstack.robots.options import Vector3
from lexstack.tasks.approach import Approach, check_approach
from lexstack.tasks.directions import check_direction, turn_between, unit
from lexstack.tasks.frame_task import check_frame, task_name
from lexstack.types import LinearTask

_ALIGNED = 1e-6  # rad


@dataclass(frozen=True, slots=True)
class ConeParameters:
    """Parameters of the task ``cone``."""

    angle: Annotated[
        float, Range(0.0, math.pi, open=True)
    ]  # rad, between axis and direction, at most
    frame: str = TOOL  # of the robot: a link or joint of its description
    axis: Vector3 = (0.0, 0.0, 1.0)  # in the frame; its length does not matter
    direction: Vector3 = (0.0, 0.0, -1.0)  # in the world; its length does not matter
    deceleration: float = 2.0  # a [rad/s2], with which an approach may end
    gain: float = 5.0  # g [1/s], of the last part of an approach, at most 1/dt

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        check_direction(where, axis=self.axis, direction=self.direction)


class Cone:
    """(d x a) / |d x a| . (J_w chi) <= w(angle - theta), with the measured axis."""

    def __init__(self, team: Team, robot: int, parameters: ConeParameters, where: str) -> None:
        """Make the task of the robot at place ``robot``; raises for a frame that is not there."""
        self.name = task_name(team, robot, "cone", parameters.frame)
        self.robots = (robot,)
        check_frame(team, robot, parameters.frame, f"{where}: frame")
        check_approach(where, parameters.gain, parameters.deceleration, team.dt)
        self._columns = team.slices[robot]
        self._n = team.n
        self._parameters = parameters
        self._axis, self._direction = unit(parameters.axis), unit(parameters.direction)
        self._approach = Approach.of(team, robot, parameters.gain, parameters.deceleration)
        self._open = np.array([-np.inf])

    @classmethod
    def from_config(cls, team: Team, robot: int, parameters: dict[str, Any], where: str) -> Cone:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(ConeParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return one row [rad/s]."""
        pose, jacobian = kinematics.frame(self.robots[0], self._parameters.frame)
        turn = turn_between(self._direction, pose.rotation @ self._axis)
        theta = math.sqrt(float(turn @ turn))
        matrix = np.zeros((1, self._n))
        if theta < _ALIGNED:
            return LinearTask(self.name, matrix, self._open, -self._open)
        row = (turn / theta) @ jacobian[3:]
        matrix[0, self._columns] = row
        upper = self._approach.speed(self._parameters.angle - theta, row)
        return LinearTask(self.name, matrix, self._open, upper)
