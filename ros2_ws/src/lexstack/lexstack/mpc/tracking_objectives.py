"""The tasks of the MPC: their references, weights and costs over the horizon, H(8)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError
from lexstack.mpc.measures import Kind, Measure, measure_of
from lexstack.mpc.options import HtmpcConfig, TaskWeightsConfig
from lexstack.mpc.stage_kinematics import StageKinematics
from lexstack.mpc.unicycle_lead import UnicycleLead
from lexstack.robots import RobotModel
from lexstack.robots.assembly import TOOL
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]
Moves = Literal["all", "arm", "base"]


@dataclass(frozen=True, slots=True, eq=False)
class Objective:
    """One level of H(7): a task with its reference over the horizon.

    Attributes:
        name: for people, e.g. ``ee_position``.
        kind: what follows the reference.
        reference: at the states 1 to N, shape (N, r), world frame: x y z for ``ee_position``,
            x y z and quaternion x y z w for ``ee_pose``, the quaternion alone for
            ``ee_orientation``, x y for ``base_position``, x y yaw for ``base_pose``, one angle
            or length per joint for ``joint_positions``.
        moves: the joints that this level may use; the arm or the base alone makes ST-Arch.
        frame: which one an end-effector kind moves, as ``RobotModel.frame`` knows it.
        joints: of ``joint_positions``; empty: all but the base's.
    """

    name: str
    kind: Kind
    reference: Matrix
    moves: Moves = "all"
    frame: str = TOOL
    joints: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class _Form:
    """What tasks of one kind have in common; see ``Task`` for the attributes."""

    measure: Measure
    weights: Matrix
    binding: Matrix
    tolerance: Vector
    moving: Vector | None


class Task:
    """An objective with its weights: what one level minimises and later levels must not spoil.

    Attributes:
        objective: what it was made from.
        measure: how its error is measured.
        reference: at the states 1 to N, shape (N, r): the objective's, or what leads to it.
        weights: Q at the states 1 to N - 1 and P at N, on the diagonal, shape (N, s).
        binding: weights of the rows that bind levels below, 0 for others, shape (N, s).
        tolerance: delta of H(13) per row, shape (s,), m and rad; inf: the row binds no level below.
        moving: 1 where the level may use a joint, else 0, shape (n,); None: everywhere 1.
        frame: which the kinematics must have; empty: none.
        inputs: (v', w') of a base that is led, at the stages, shape (N, 2): a first guess; or None.
    """

    def __init__(
        self,
        objective: Objective,
        config: HtmpcConfig,
        robot: RobotModel,
        lead: UnicycleLead | None = None,
        state: tuple[Vector, Vector] | None = None,
    ) -> None:
        """Check it; raises InputError for a reference or name that does not fit the robot.

        Args:
            objective: what it is made from.
            config: parameters of the MPC.
            robot: whose task.
            lead: of a differential base: a task of the base then follows what leads to its
                reference, from the ``state``. The yaw of that motion is weighed also where only
                the position is asked for, but levels below may change it.
            state: the measured q and v.
        """
        self.objective = objective
        form = _form_of(_subject(objective), config, robot, guided=False)
        expected = (config.horizon, form.measure.columns)
        if objective.reference.shape != expected or not np.isfinite(objective.reference).all():
            raise InputError(
                f"task {objective.name}: reference of shape {objective.reference.shape}, "
                f"expected finite numbers of shape {expected}"
            )
        self.inputs: Matrix | None = None
        self.reference = objective.reference
        if lead is not None and state is not None and objective.kind.startswith("base"):
            self.reference, self.inputs = lead.motion(*state, objective.reference)
            form = _form_of(_subject(objective), config, robot, guided=True)
        self.measure = form.measure
        self.frame = form.measure.frame
        self.weights, self.binding = form.weights, form.binding
        self.tolerance, self.moving = form.tolerance, form.moving

    def error(self, at: StageKinematics) -> Matrix:
        """Return e at the states 1 to N, shape (N, s)."""
        return self._found(at)[0]

    def cost_at(self, at: StageKinematics) -> float:
        """Return J of H(8), without the state 0, which no input changes."""
        return self._found(at)[1]

    def _found(self, at: StageKinematics) -> tuple[Matrix, float]:
        """Return error and cost; levels and their constraints ask for them again and again."""
        if self not in at.found:
            error = self.measure.error(at, self.reference)
            error.setflags(write=False)
            at.found[self] = error, self.cost(error)
        found: tuple[Matrix, float] = at.found[self]
        return found

    def jacobian(self, at: StageKinematics) -> Array:
        """Return de/dq, shape (N, s, n)."""
        jacobian = self.measure.jacobian(at, self.reference)
        if jacobian.ndim == 2:
            jacobian = np.broadcast_to(jacobian, (len(at.q), *jacobian.shape))
        return jacobian

    def cost(self, error: Matrix) -> float:
        """Return J of H(8) for an error of shape (N, s)."""
        return 0.5 * float(np.vdot(self.weights * error, error))

    def bound_cost(self, error: Matrix) -> float:
        """Return J of H(8) of the rows that bind levels below, for an error of shape (N, s)."""
        return 0.5 * float(np.vdot(self.binding * error, error))

    def stage_costs(self, error: Matrix) -> Vector:
        """Return the part of each state in ``bound_cost``, shape (N,)."""
        return np.asarray(0.5 * np.einsum("ks,ks->k", self.binding * error, error))

    @property
    def stage_tolerance(self) -> Vector:
        """The cost of an error whose norm is the tolerance, at each state, shape (N,)."""
        lengths = self.measure.lengths
        share = np.where(np.isinf(self.tolerance), 0.0, np.square(self.tolerance))
        for rows in (lengths, ~lengths):
            share[rows] /= max(1, int(rows.sum()))
        return np.asarray(0.5 * self.weights @ share)


def weights_of(kind: Kind, config: HtmpcConfig) -> TaskWeightsConfig:
    """Return the weights of a kind of task."""
    if kind == "joint_positions":
        return config.joint
    return config.ee if kind.startswith("ee") else config.base


_Subject = tuple[str, Kind, Moves, str, tuple[str, ...]]


def _subject(objective: Objective) -> _Subject:
    """Return what of a robot an objective moves, and with which joints."""
    return objective.name, objective.kind, objective.moves, objective.frame, objective.joints


@lru_cache(maxsize=256)
def _form_of(subject: _Subject, config: HtmpcConfig, robot: RobotModel, *, guided: bool) -> _Form:
    """Return what does not change from solve to solve; raises InputError as ``measure_of``.

    ``guided``: the pose of a motion that leads to the reference is followed.
    """
    name, kind, moves, frame, joints = subject
    asked = Objective(name, kind, np.zeros((0, 0)), moves, frame, joints)
    measure = measure_of(replace(asked, kind="base_pose") if guided else asked, robot)
    chosen, lengths = weights_of(kind, config), measure.lengths
    weights = _weights(chosen, measure, config.horizon)
    tolerance = np.where(lengths, chosen.tolerance, chosen.tolerance_angle)
    tolerance[measure_of(asked, robot).columns :] = np.inf  # rows that only guide
    guides = np.isinf(tolerance)
    binding = np.where(guides, 0.0, weights) if guides.any() else weights
    moving = _moving(moves, robot)
    for array in (weights, binding, tolerance):
        array.setflags(write=False)
    return _Form(measure, weights, binding, tolerance, moving)


def _moving(moves: Moves, robot: RobotModel) -> Vector | None:
    """Return 1 for the joints that a level may use, else 0, shape (n,); None for all."""
    if moves == "all":
        return None
    base = np.arange(robot.n) < robot.arm.start
    return (base if moves == "base" else ~base).astype(np.float64)


def _weights(config: TaskWeightsConfig, measure: Measure, stages: int) -> Matrix:
    """Return the diagonals of Q_k and P, shape (N, s)."""
    weights = np.empty((stages, measure.rows))
    weights[:] = np.where(measure.lengths, config.stage, config.stage_angle)
    weights[-1] = np.where(measure.lengths, config.terminal, config.terminal_angle)
    return weights
