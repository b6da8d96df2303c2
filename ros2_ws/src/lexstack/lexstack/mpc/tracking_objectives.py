"""The tasks of the MPC: errors e_k and their Jacobians at all stages, H(6) and H(8)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError
from lexstack.mpc.options import HtmpcConfig, TaskWeightsConfig
from lexstack.mpc.stage_kinematics import StageKinematics
from lexstack.robots.spatial import from_quaternions, log3_all, log_slopes
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]
Kind = Literal["ee_position", "ee_pose", "base_position", "base_pose"]
"""What a task moves, and in which coordinates; see ``Objective``."""

Moves = Literal["all", "arm", "base"]


@dataclass(frozen=True, slots=True, eq=False)
class Objective:
    """One level of H(7): a task with its reference over the horizon.

    Attributes:
        name: for people, e.g. ``ee_position``.
        kind: what follows the reference.
        reference: at the states 1 to N, shape (N, r), world frame: x y z for ``ee_position``,
            x y z and quaternion x y z w for ``ee_pose``, x y for ``base_position``, x y yaw for
            ``base_pose``.
        moves: the joints that this level may use; the arm or the base alone makes ST-Arch.
    """

    name: str
    kind: Kind
    reference: Matrix
    moves: Moves = "all"


@dataclass(frozen=True, slots=True)
class Measure:
    """How an error is measured: e of shape (N, s), and J = de/dq, (N, s, n) or (s, n) constant.

    Attributes:
        lengths: how many rows, the first ones, are lengths [m]; the rest are angles [rad].
        rows: s.
        columns: r, of the reference.
    """

    lengths: int
    rows: int
    columns: int
    error: Callable[[StageKinematics, Matrix], Matrix]
    jacobian: Callable[[StageKinematics, Matrix], Array]


def _ee_position(at: StageKinematics, reference: Matrix) -> Matrix:
    """Return p - r, shape (N, 3)."""
    return at.position - reference


def _ee_position_jacobian(at: StageKinematics, _reference: Matrix) -> Array:
    """Return its Jacobian, shape (N, 3, n)."""
    return at.jacobian[:, :3]


def _turned(at: StageKinematics, reference: Matrix) -> Matrix:
    """Return log(R R_d^T), the rotation from the reference to the tool, world axes, (N, 3)."""
    desired = from_quaternions(reference[:, 3:])
    return log3_all(at.rotation @ desired.transpose(0, 2, 1))


def _ee_pose(at: StageKinematics, reference: Matrix) -> Matrix:
    """Return p - r and the rotation vector from the reference to the tool, shape (N, 6)."""
    return np.concatenate((at.position - reference[:, :3], _turned(at, reference)), axis=1)


def _ee_pose_jacobian(at: StageKinematics, reference: Matrix) -> Array:
    """Return its exact Jacobian, shape (N, 6, n)."""
    jacobian = at.jacobian.copy()
    jacobian[:, 3:] = log_slopes(_turned(at, reference)) @ at.jacobian[:, 3:]
    return jacobian


def _base_position(at: StageKinematics, reference: Matrix) -> Matrix:
    """Return x and y off the reference, shape (N, 2)."""
    return at.q[:, :2] - reference


def _base_pose(at: StageKinematics, reference: Matrix) -> Matrix:
    """Return x, y and yaw off the reference, yaw in (-pi, pi], shape (N, 3)."""
    error = at.q[:, :3] - reference
    error[:, 2] = np.pi - np.remainder(np.pi - error[:, 2], 2.0 * np.pi)
    return error


def _base_rows(rows: int) -> Callable[[StageKinematics, Matrix], Array]:
    """Return the function for the constant Jacobian of the base, shape (rows, n)."""
    return lambda at, _reference: np.eye(rows, at.q.shape[1])


MEASURES: dict[Kind, Measure] = {
    "ee_position": Measure(3, 3, 3, _ee_position, _ee_position_jacobian),
    "ee_pose": Measure(3, 6, 7, _ee_pose, _ee_pose_jacobian),
    "base_position": Measure(2, 2, 2, _base_position, _base_rows(2)),
    "base_pose": Measure(2, 3, 3, _base_pose, _base_rows(3)),
}
"""The kinds of tasks by their names."""


class Task:
    """An objective with its weights: what one level minimises and later levels must not spoil.

    Attributes:
        objective: what it was made from.
        weights: Q at the states 1 to N - 1 and P at N, on the diagonal, shape (N, s).
        tolerance: delta of H(13) per row, shape (s,), m and rad.
        moving: 1 where the level may use a joint, else 0, shape (n,); None: everywhere 1.
    """

    def __init__(self, objective: Objective, config: HtmpcConfig, joints: int) -> None:
        """Check the reference; raises InputError for a shape or value that is wrong."""
        if objective.kind not in MEASURES:
            known = ", ".join(MEASURES)
            raise InputError(f"task {objective.name}: kind {objective.kind!r}; known: {known}")
        self.objective = objective
        self._measure = measure = MEASURES[objective.kind]
        expected = (config.horizon, measure.columns)
        if objective.reference.shape != expected or not np.isfinite(objective.reference).all():
            raise InputError(
                f"task {objective.name}: reference of shape {objective.reference.shape}, "
                f"expected finite numbers of shape {expected}"
            )
        weights = config.ee if objective.kind.startswith("ee") else config.base
        self.weights = _weights(weights, measure, config.horizon)
        self.tolerance: Vector = np.full(measure.rows, weights.tolerance)
        self.tolerance[measure.lengths :] = weights.tolerance_angle
        self.moving = _moving(objective.moves, joints)

    def error(self, at: StageKinematics) -> Matrix:
        """Return e at the states 1 to N, shape (N, s)."""
        return self._found(at)[0]

    def cost_at(self, at: StageKinematics) -> float:
        """Return J of H(8), without the state 0, which no input changes."""
        return self._found(at)[1]

    def _found(self, at: StageKinematics) -> tuple[Matrix, float]:
        """Return error and cost; levels and their constraints ask for them again and again."""
        if self not in at.found:
            error = self._measure.error(at, self.objective.reference)
            error.setflags(write=False)
            at.found[self] = error, self.cost(error)
        found: tuple[Matrix, float] = at.found[self]
        return found

    def jacobian(self, at: StageKinematics) -> Array:
        """Return de/dq, shape (N, s, n)."""
        jacobian = self._measure.jacobian(at, self.objective.reference)
        if jacobian.ndim == 2:
            jacobian = np.broadcast_to(jacobian, (len(at.q), *jacobian.shape))
        return jacobian

    def cost(self, error: Matrix) -> float:
        """Return J of H(8) for an error of shape (N, s)."""
        return 0.5 * float(np.vdot(self.weights * error, error))

    def stage_costs(self, error: Matrix) -> Vector:
        """Return the part of each state in J, shape (N,)."""
        return np.asarray(0.5 * np.einsum("ks,ks->k", self.weights * error, error))

    @property
    def stage_tolerance(self) -> Vector:
        """The cost of an error whose norm is the tolerance, at each state, shape (N,)."""
        lengths = self._measure.lengths
        share = np.square(self.tolerance)
        share[:lengths] /= lengths
        share[lengths:] /= max(1, len(share) - lengths)
        return np.asarray(0.5 * self.weights @ share)


def _moving(moves: Moves, joints: int) -> Vector | None:
    """Return 1 for the joints that a level may use, else 0, shape (n,); None for all."""
    if moves == "all":
        return None
    base = np.arange(joints) < 3
    return (base if moves == "base" else ~base).astype(np.float64)


def _weights(config: TaskWeightsConfig, measure: Measure, stages: int) -> Matrix:
    """Return the diagonals of Q_k and P, shape (N, s)."""
    weights = np.empty((stages, measure.rows))
    weights[:, : measure.lengths] = config.stage
    weights[:, measure.lengths :] = config.stage_angle
    weights[-1, : measure.lengths] = config.terminal
    weights[-1, measure.lengths :] = config.terminal_angle
    return weights
