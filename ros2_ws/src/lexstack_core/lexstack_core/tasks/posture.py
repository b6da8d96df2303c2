"""Arm posture, T(22) to T(25) with the sign, the gain and the mid-range put right."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack_core.config.checks import finite, positive, same_length
from lexstack_core.config.reader import build
from lexstack_core.linear import Curve, LinearTask
from lexstack_core.model import Kinematics, Team
from lexstack_core.model.robot import ARM
from lexstack_core.references import References


@dataclass(frozen=True, slots=True)
class PostureParameters:
    """Parameters of the task ``posture``."""

    gain: float = 1.0  # lambda [1/s]
    target: tuple[float, ...] | None = None  # rad; default: mid-range (q_max + q_min) / 2

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        positive(where, gain=self.gain)
        if self.target is not None:
            finite(where, target=self.target)


class Posture:
    """Gamma chi -> lambda (q_d - q*), with the integrated arm posture q*."""

    def __init__(
        self, team: Team, robot: int, parameters: PostureParameters, where: str = "posture"
    ) -> None:
        """Make the task of the robot at place ``robot``; raises for a target of wrong length."""
        limits = team.robots[robot].limits
        middle = 0.5 * (limits.position_lower[ARM] + limits.position_upper[ARM])
        if parameters.target is not None:
            same_length(where, len(middle), target=parameters.target)
        self.name = f"{team.names[robot]}/posture"
        self.robots = (robot,)
        self._target = middle if parameters.target is None else np.array(parameters.target)
        start = team.slices[robot].stop - len(middle)
        self._part = slice(start, team.slices[robot].stop)
        self._matrix = np.eye(len(middle), team.n, start)
        self._matrix.setflags(write=False)  # solvers may remember it
        self._gain = parameters.gain
        self._curve = Curve(parameters.gain, (robot,), (team.slices[robot],))

    @classmethod
    def from_config(cls, team: Team, robot: int, parameters: dict[str, Any], where: str) -> Posture:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(PostureParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return one row per arm joint [rad/s]."""
        error = self._target - kinematics.state.q_star[self._part]
        return LinearTask.equality(self.name, self._matrix, self._gain * error, self._curve)
