"""Position of a frame on one side of a plane: an inequality on the speed of approach.

With the plane's unit normal n and its offset, and r = n . p - offset - margin, the room that is
left,

    n . (J_v chi) >= -w(r)

with w(r) the largest speed of approach from which the frame can still stop, see
``collision_avoidance``. A room that is negative leads back by the same law. pink:
``PositionBarrier`` along the axes of the world; mink and placo have none for frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.options import Finite, NotNegative, build
from lexstack.references import TOOL, References
from lexstack.robots import Kinematics, Team
from lexstack.robots.options import Vector3
from lexstack.tasks.approach import Approach, check_approach
from lexstack.tasks.directions import check_direction, unit
from lexstack.tasks.frame_task import check_frame, task_name
from lexstack.types import LinearTask


@dataclass(frozen=True, slots=True)
class HalfSpaceParameters:
    """Parameters of the task ``half_space``."""

    normal: Vector3  # in the world, towards the allowed side; its length does not matter
    offset: Finite = 0.0  # m: of the plane from the origin, along the normal
    frame: str = TOOL  # of the robot: a link or joint of its description
    margin: NotNegative = 0.0  # m, to the plane
    deceleration: float = 1.0  # a [m/s2], with which an approach may end
    gain: float = 5.0  # g [1/s], of the last part of an approach, at most 1/dt

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        check_direction(where, normal=self.normal)


class HalfSpace:
    """n . (J_v chi) >= -w(r), with the measured position."""

    def __init__(self, team: Team, robot: int, parameters: HalfSpaceParameters, where: str) -> None:
        """Make the task of the robot at place ``robot``; raises for a frame that is not there."""
        self._normal = unit(parameters.normal)
        normal = ",".join(f"{x:g}" for x in parameters.normal)
        frame = task_name(team, robot, "half_space", parameters.frame)
        self.name = f"{frame}[{normal}]"
        self.robots = (robot,)
        check_frame(team, robot, parameters.frame, f"{where}: frame")
        check_approach(where, parameters.gain, parameters.deceleration, team.dt)
        self._columns = team.slices[robot]
        self._n = team.n
        self._parameters = parameters
        self._least = parameters.offset + parameters.margin
        self._approach = Approach.of(team, robot, parameters.gain, parameters.deceleration)
        self._open = np.array([np.inf])

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> HalfSpace:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(HalfSpaceParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return one row [m/s]."""
        pose, jacobian = kinematics.frame(self.robots[0], self._parameters.frame)
        row = self._normal @ jacobian[:3]
        room = float(self._normal @ pose.position) - self._least
        matrix = np.zeros((1, self._n))
        matrix[0, self._columns] = row
        return LinearTask(self.name, matrix, -self._approach.speed(room, row), self._open)
