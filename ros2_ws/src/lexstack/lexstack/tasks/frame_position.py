"""End-effector position alone, the first three rows of T(16): the orientation stays free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.options import Positive, build
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.tasks.feed_forward import feed_forward
from lexstack.tasks.frame_pose import saturated
from lexstack.types import Curve, LinearTask


@dataclass(frozen=True, slots=True)
class EePositionParameters:
    """Parameters of the task ``ee_position``."""

    gain: Positive = 3.0  # K_p [1/s]
    max_linear: Positive = 0.5  # m/s, saturation of |K_p e|


class EePosition:
    """J_v chi -> p_dot_d + sat(K_p (p_d - p)), with the measured position p of the tool."""

    def __init__(self, team: Team, robot: int, parameters: EePositionParameters) -> None:
        """Make the task of the robot at place ``robot`` of the team."""
        self.name = f"{team.names[robot]}/ee_position"
        self.robots = (robot,)
        self._robot = robot
        self._columns = team.slices[robot]
        self._n = team.n
        self._team = team
        self._parameters = parameters
        limits = (parameters.max_linear,)
        self._curve = Curve(parameters.gain, (robot,), (self._columns,), (1.0,), limits)

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> EePosition:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(EePositionParameters, parameters, where))

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 3 rows [m/s], axes of the world frame."""
        error = references.ee[self._robot].position - kinematics.tools[self._robot].position
        target = saturated(self._parameters.gain * error, self._parameters.max_linear)
        matrix = np.zeros((3, self._n))
        matrix[:, self._columns] = kinematics.jacobians[self._robot][:3]
        feed = references.twist(self._robot)
        if feed is not None:
            feed = feed_forward(feed, kinematics, self._team, self._robot)[:3]
        return LinearTask.equality(self.name, matrix, target, self._curve, feed)
