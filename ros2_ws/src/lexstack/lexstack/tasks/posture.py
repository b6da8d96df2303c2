"""Arm posture, T(22) to T(25) with the sign, the gain and the mid-range put right.

    W Gamma chi -> W (q_dot_d + lambda (q_d - q*))

with W the roots of the weights. A posture among the references (``Target.posture``) takes the place
of the parameter's. pink and mink: ``PostureTask``; placo: ``JointsTask``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from lexstack.compiled import kernel
from lexstack.errors import ConfigurationError
from lexstack.options import Finite, Positive, build, same_length, shown
from lexstack.references import References
from lexstack.robots import Kinematics, RobotModel, Team
from lexstack.tasks.base_pose import KERNEL
from lexstack.types import Curve, LinearTask, Vector

_FLOAT = np.dtype(np.float64)


@dataclass(frozen=True, slots=True)
class PostureParameters:
    """Parameters of the task ``posture``."""

    # rad; None: the robot's own posture; mid_range: (q_max + q_min) / 2, as in T
    target: Literal["mid_range"] | tuple[Finite, ...] | None = None
    gain: Positive = 1.0  # lambda [1/s]
    joints: tuple[str, ...] = ()  # names of the arm's joints that have a row; empty: all
    weights: tuple[Positive, ...] = ()  # of the squared residual of each row; empty: all 1


class Posture:
    """Gamma chi -> q_dot_d + lambda (q_d - q*), with the integrated arm posture q*.

    Attributes:
        led: whether a posture among the references takes the place of its own target.
        target: its own, shape (n_arm,), rad.
    """

    def __init__(
        self, team: Team, robot: int, parameters: PostureParameters, where: str = "posture"
    ) -> None:
        """Make the task of the robot at place ``robot``; raises for a target of wrong length."""
        self.name = f"{team.names[robot]}/posture"
        self.robots = (robot,)
        model = team.robots[robot]
        self.led = True
        self.target = posture_target(model, parameters, where)
        start, end = team.slices[robot].stop - len(self.target), team.q_slices[robot].stop
        self._place = slice(end - len(self.target), end)
        self._matrix = np.eye(len(self.target), team.n, start)
        self._kept: list[int] | None = None
        if parameters.joints:
            self._kept = _kept(model, parameters.joints, where)
            self._matrix = self._matrix[self._kept]
        self._roots: Vector | None = None
        if parameters.weights:
            same_length(where, len(self._matrix), weights=parameters.weights)
            self._roots = np.sqrt(parameters.weights)
            self._matrix = self._roots[:, None] * self._matrix
        self._matrix.setflags(write=False)  # solvers may remember it
        self._gain = parameters.gain
        self._curve = Curve(parameters.gain, (robot,), (team.slices[robot],))

    @classmethod
    def from_config(cls, team: Team, robot: int, parameters: dict[str, Any], where: str) -> Posture:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(PostureParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return one row per arm joint that is kept [rad/s], times the root of its weight."""
        motion = references.motion
        target = self.target
        if self.led:
            target = motion.postures.get(self.robots[0], target)
        q_star = kinematics.state.q_star
        feed = motion.posture_rates.get(self.robots[0]) if self.led else None
        fast = kernel(KERNEL) if self._kept is None and self._roots is None else None
        if fast is not None and target.dtype is q_star.dtype is _FLOAT:
            asked = np.empty(target.size)
            fast.towards(target, q_star, self._place.start, self._gain, -1, asked)
            return LinearTask.equality(self.name, self._matrix, asked, self._curve, feed)
        error = target - q_star[self._place]
        if self._kept is not None:
            error, feed = error[self._kept], None if feed is None else feed[self._kept]
        if self._roots is not None:
            error, feed = self._roots * error, None if feed is None else self._roots * feed
        return LinearTask.equality(self.name, self._matrix, self._gain * error, self._curve, feed)


def _kept(model: RobotModel, joints: tuple[str, ...], where: str) -> list[int]:
    """Return the places of joints among those of the arm; raises for others, or one twice."""
    known = model.joints[model.arm]
    for joint in joints:
        if joint not in known or joints.count(joint) > 1:
            what = "stands in it twice" if joint in known else f"unknown; known: {', '.join(known)}"
            raise ConfigurationError(f"{where}: joints: {shown(joint)}: {what}")
    return [known.index(joint) for joint in joints]


def posture_target(model: RobotModel, parameters: PostureParameters, where: str) -> Vector:
    """Return q_d, shape (arm,), rad; raises ConfigurationError for a target of wrong length."""
    if parameters.target is None:
        return model.posture
    if parameters.target == "mid_range":
        return model.mid_range
    same_length(where, len(model.mid_range), target=parameters.target)
    return np.array(parameters.target)
