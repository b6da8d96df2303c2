"""Manipulability of a frame by the arm: joint velocities along its gradient.

With the rows J of the frame's Jacobian that count, on the arm's joints alone,

    w = sqrt(det(J J^T + reg I))        Gamma chi -> sat(gain d log w / dq)

as a lower level: it turns the arm away from singularities as far as the levels above leave it free.
d J / dq is exact: of the columns v_j, w_j of the joints in the order of the chain,
d v_j / dq_i = w_i x v_j for i <= j and w_j x v_i for i > j, d w_j / dq_i = w_i x w_j for i < j.
pink and placo: ``ManipulabilityTask``; mink has none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from lexstack.options import Positive, build
from lexstack.references import TOOL, References
from lexstack.robots import Kinematics, Team
from lexstack.tasks.frame_pose import saturated
from lexstack.tasks.frame_task import check_frame, task_name
from lexstack.types import LinearTask, Matrix, Vector

_REGULAR = 1e-6  # m^2 or 1: singular values below its root count as lost
_ROWS = {"position": slice(0, 3), "orientation": slice(3, 6), "pose": slice(0, 6)}


@dataclass(frozen=True, slots=True)
class ManipulabilityParameters:
    """Parameters of the task ``manipulability``."""

    frame: str = TOOL  # of the robot: a link or joint of its description
    rows: Literal["position", "orientation", "pose"] = "pose"  # of the Jacobian that count
    gain: Positive = 0.2  # rad^2/s
    max_speed: Positive = 0.5  # rad/s, saturation of the norm of the joint velocities


class Manipulability:
    """Gamma chi -> sat(gain d log w / dq), at the measured configuration."""

    def __init__(
        self, team: Team, robot: int, parameters: ManipulabilityParameters, where: str
    ) -> None:
        """Make the task of the robot at place ``robot``; raises for a frame that is not there."""
        self.name = task_name(team, robot, "manipulability", parameters.frame)
        self.robots = (robot,)
        check_frame(team, robot, parameters.frame, f"{where}: frame")
        columns, self._arm = team.slices[robot], team.robots[robot].arm
        arm = range(columns.start, columns.stop)[self._arm]
        self._matrix = np.eye(len(arm), team.n, arm.start)
        self._model, self._places = team.robots[robot], team.q_slices[robot]
        self._matrix.setflags(write=False)  # solvers may remember it
        self._parameters = parameters

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> Manipulability:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(ManipulabilityParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return one row per arm joint [rad/s]."""
        p = self._parameters
        joints = self._model.map
        if joints is None:
            _, jacobian = kinematics.frame(self.robots[0], p.frame)
            gradient = log_gradient(jacobian[:, self._arm], _ROWS[p.rows])
        else:
            every = self._model.all_joints(kinematics.state.q[self._places], p.frame)
            gradient = log_gradient(every, _ROWS[p.rows], joints.matrix[:, self._arm])
        target = saturated(p.gain * gradient, p.max_speed)
        return LinearTask.equality(self.name, self._matrix, target)


def log_manipulability(jacobian: Matrix, rows: slice) -> float:
    """Return log w of some rows of a Jacobian, shape (6, n)."""
    kept = jacobian[rows]
    return 0.5 * float(np.linalg.slogdet(kept @ kept.T + _REGULAR * np.eye(len(kept)))[1])


def log_gradient(jacobian: Matrix, rows: slice, follows: Matrix | None = None) -> Vector:
    """Return d log w / dq, shape (n,), of a frame's Jacobian on a chain of joints.

    Args:
        jacobian: shape (6, n_all).
        rows: of it that count.
        follows: velocities of the chain's joints by those of n controlled ones, some of which
            mimic others, shape (n_all, n); None: they are the same.
    """
    linear, angular = jacobian[:3].T, jacobian[3:].T
    n = len(linear)
    by = np.cross(angular[:, None], linear[None])  # [i, j]: w_i x v_j
    later = np.triu(np.ones((n, n), dtype=np.bool_))[:, :, None]
    turned = np.cross(angular[:, None], angular[None])
    slopes = np.concatenate(
        (np.where(later, by, by.transpose(1, 0, 2)), np.where(later, turned, 0.0)), axis=2
    )
    kept = jacobian[rows] if follows is None else jacobian[rows] @ follows
    weights = np.linalg.solve(kept @ kept.T + _REGULAR * np.eye(len(kept)), kept)
    if follows is None:
        return np.asarray(np.einsum("rj,ijr->i", weights, slopes[:, :, rows]))
    # log w depends on J E; what a controlled joint moves turns by all that follow it.
    every = np.einsum("rj,ijr->i", weights @ follows.T, slopes[:, :, rows])
    return np.asarray(follows.T @ every)
