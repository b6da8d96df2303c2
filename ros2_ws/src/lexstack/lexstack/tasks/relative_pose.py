"""Relative pose of two tools: both robots hold one object, wherever the object goes.

The tools' references say where each of them shall be, and so how they shall stand to each other:

    p_r = R_ad^T (p_bd - p_ad)        R_r = R_ad^T R_bd

With tool a where it is, tool b belongs at R_a p_r + p_a, turned by R_a R_r. Its error, in the
world frame, does not depend on where the object is:

    e_p = p_a + R_a p_r - p_b         e_R = R_b log3(R_b^T R_a R_r)

and shrinks by exp(-K_p t) where the tools move as a rigid object would, but for the way back:

    v_b - v_a - w_a x (R_a p_r) = K_p e_p          w_b - w_a = K_p e_R

References that move together, as the ends of one object, leave the task as it is: the object goes
where a task below takes it, e.g. ``ee_pose`` of one of the robots.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import Positive, build
from lexstack.references import References
from lexstack.robots import Kinematics, Pose, Team
from lexstack.tasks.frame_pose import pose_error, saturated
from lexstack.types import Curve, LinearTask, Matrix, Vector


@dataclass(frozen=True, slots=True)
class RelativePoseParameters:
    """Parameters of the task ``relative_pose``."""

    other: str  # name of the robot that holds the object too
    gain: Positive = 3.0  # K_p [1/s]
    max_linear: Positive = 0.5  # m/s, saturation of |K_p e_p|
    max_angular: Positive = 1.0  # rad/s, saturation of |K_p e_R|


class RelativePose:
    """J_b chi - G J_a chi -> sat(K_p e), with G the motion of the object's other end."""

    def __init__(
        self, team: Team, robot: int, parameters: RelativePoseParameters, where: str
    ) -> None:
        """Make the task of two robots; raises ConfigurationError where they are not two."""
        try:
            other = team.index(parameters.other)
        except ConfigurationError as error:
            raise ConfigurationError(f"{where}: other: {error}") from error
        if other == robot:
            raise ConfigurationError(
                f"{where}: other: {parameters.other!r} is the task's own robot: "
                "the task needs a robot and another one"
            )
        self.name = f"{team.names[robot]}/relative_pose"
        self.robots = (robot, other)
        self._robots = robot, other
        self._columns = team.slices[robot], team.slices[other]
        self._n = team.n
        self._parameters = parameters
        limits = (parameters.max_linear, parameters.max_angular)
        signs = (-1.0, 1.0)
        self._curve = Curve(parameters.gain, self._robots, self._columns, signs, limits)

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> RelativePose:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(RelativePoseParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 6 rows, m/s then rad/s, in the world frame."""
        one, other = self._robots
        goal = other_end(kinematics.tools[one], references.ee[one], references.ee[other])
        error = self._parameters.gain * pose_error(kinematics.tools[other], goal)
        target = np.empty(6)
        target[:3] = saturated(error[:3], self._parameters.max_linear)
        target[3:] = saturated(error[3:], self._parameters.max_angular)
        held = kinematics.jacobians[one]
        lever = goal.position - kinematics.tools[one].position
        matrix = np.zeros((6, self._n))
        matrix[:, self._columns[0]] = -held
        matrix[:3, self._columns[0]] += cross(lever) @ held[3:]
        matrix[:, self._columns[1]] = kinematics.jacobians[other]
        feed = self._feed(kinematics, references)
        return LinearTask.equality(self.name, matrix, target, self._curve, feed)

    def _feed(self, kinematics: Kinematics, references: References) -> Vector | None:
        """Return the velocity of the other tool's goal on the object, shape (6,); None: it rests.

        The references' relative motion, turned with the object; moving together is none.
        """
        one, other = self._robots
        held, free = references.twist(one), references.twist(other)
        if held is None and free is None:
            return None
        held = np.zeros(6) if held is None else held
        free = np.zeros(6) if free is None else free
        first = references.ee[one]
        lever = references.ee[other].position - first.position
        turn = kinematics.tools[one].rotation @ first.rotation.T
        linear = free[:3] - held[:3] - np.cross(held[3:], lever)
        return np.concatenate((turn @ linear, turn @ (free[3:] - held[3:])))


def other_end(tool: Pose, reference: Pose, other_reference: Pose) -> Pose:
    """Return where the other tool belongs, given where the first one is, world frame.

    Args:
        tool: of the first robot, R_a and p_a.
        reference: of that tool.
        other_reference: of the other robot's tool.
    """
    turn = tool.rotation @ reference.rotation.T
    lever = turn @ (other_reference.position - reference.position)
    return Pose(tool.position + lever, turn @ other_reference.rotation)


def cross(vector: Vector) -> Matrix:
    """Return the matrix of ``vector x``, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
