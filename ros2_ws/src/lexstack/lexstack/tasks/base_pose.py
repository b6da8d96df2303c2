"""Base pose, T(26) to T(30) with the sign and the gain put right."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.options import build, positive
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.robots.spatial import wrap
from lexstack.types import Curve, LinearTask


@dataclass(frozen=True, slots=True)
class BaseParameters:
    """Parameters of the task ``base``."""

    gain: float = 1.0  # lambda [1/s]

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a gain that is not positive."""
        positive(where, gain=self.gain)


class Base:
    """Phi chi -> x_dot_d + lambda (x_d - x*), with the integrated base pose x* and yaw wrapped."""

    def __init__(self, team: Team, robot: int, parameters: BaseParameters) -> None:
        """Make the task of the robot at place ``robot`` of the team."""
        self.name = f"{team.names[robot]}/base"
        self.robots = (robot,)
        self._robot = robot
        start = team.slices[robot].start
        self._part = slice(start, start + 3)
        self._matrix = np.eye(3, team.n, start)
        self._matrix.setflags(write=False)  # solvers may remember it
        self._gain = parameters.gain
        self._curve = Curve(parameters.gain, (robot,), (team.slices[robot],))

    @classmethod
    def from_config(cls, team: Team, robot: int, parameters: dict[str, Any], where: str) -> Base:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(BaseParameters, parameters, where))

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 3 rows: x and y [m/s], yaw [rad/s], in the world frame."""
        error = references.base[self._robot] - kinematics.state.q_star[self._part]
        error[2] = wrap(error[2])
        feed = references.motion.bases.get(self._robot)
        return LinearTask.equality(self.name, self._matrix, self._gain * error, self._curve, feed)
