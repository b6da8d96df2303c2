"""Joints of a robot that move together: a linear combination of them stays at a value.

    c . chi -> gain (value - c . q*)

pink: ``JointCouplingTask``; placo: ``GearTask``; mink: ``EqualityConstraintTask`` of a joint
equality.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import Finite, Positive, build, shown
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.types import Curve, LinearTask


@dataclass(frozen=True, slots=True)
class JointCouplingParameters:
    """Parameters of the task ``joint_coupling``."""

    joints: dict[str, Finite]  # c: a coefficient of each joint that is coupled, by its name
    value: Finite = 0.0  # of c . q*: rad, or m
    gain: Positive = 1.0  # 1/s

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        if not any(self.joints.values()):
            raise ConfigurationError(f"{where}: joints: no joint has a coefficient but 0")


class JointCoupling:
    """c . chi -> gain (value - c . q*), with the integrated positions q*."""

    def __init__(
        self, team: Team, robot: int, parameters: JointCouplingParameters, where: str
    ) -> None:
        """Make the task of the robot at place ``robot``; raises for joints that are not there."""
        names = team.robots[robot].joints
        for name in parameters.joints:
            if name in team.robots[robot].without_position:
                raise ConfigurationError(
                    f"{where}: joints: {name} is a velocity of a differential base, "
                    "which has no position"
                )
            if name not in names:
                raise ConfigurationError(
                    f"{where}: joints: unknown joint {shown(name)}; known: {', '.join(names)}"
                )
        self.name = f"{team.names[robot]}/joint_coupling({'+'.join(parameters.joints)})"
        self.robots = (robot,)
        self._matrix = np.zeros((1, team.n))
        self._positions = team.joint_positions
        start = team.slices[robot].start
        for name, coefficient in parameters.joints.items():
            self._matrix[0, start + names.index(name)] = coefficient
        self._matrix.setflags(write=False)  # solvers may remember it
        self._parameters = parameters
        self._curve = Curve(parameters.gain, (robot,), (team.slices[robot],))

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> JointCoupling:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(JointCouplingParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return one row, in the unit of ``value`` per s."""
        error = self._parameters.value - self._matrix @ self._positions(kinematics.state.q_star)
        return LinearTask.equality(
            self.name, self._matrix, self._parameters.gain * error, self._curve
        )
