"""Minimum velocity, the second level of T(36)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.options import Positive, build
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.types import LinearTask


@dataclass(frozen=True, slots=True)
class VelocityDampingParameters:
    """Parameters of the task ``velocity_damping``: what a unit of each velocity costs."""

    base_cost: Positive = 1.0  # of 1 m/s or 1 rad/s of a base joint
    arm_cost: Positive = 1.0  # of 1 rad/s of an arm joint


class VelocityDamping:
    """W chi -> 0 with W the diagonal of costs."""

    def __init__(self, team: Team, robot: int, parameters: VelocityDampingParameters) -> None:
        """Make the task of the robot at place ``robot`` of the team."""
        columns = team.slices[robot]
        n = columns.stop - columns.start
        self.name = f"{team.names[robot]}/velocity_damping"
        self.robots = (robot,)
        matrix = np.eye(n, team.n, columns.start)
        matrix[team.robots[robot].base] *= parameters.base_cost
        matrix[team.robots[robot].arm] *= parameters.arm_cost
        target = np.zeros(n)
        for array in (matrix, target):
            array.setflags(write=False)  # solvers may remember it
        self._rows = LinearTask.equality(self.name, matrix, target)

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> VelocityDamping:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(VelocityDampingParameters, parameters, where))

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return one row per joint of the robot."""
        return self._rows
