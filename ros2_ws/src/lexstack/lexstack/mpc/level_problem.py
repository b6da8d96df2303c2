"""What all levels of one solve share: dynamics, effort, barriers, limits, H(9)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.barriers import LimitBarrier
from lexstack.mpc.collision_cost import Collisions
from lexstack.mpc.double_integrator import Horizon, Sensitivity
from lexstack.mpc.effort import Effort
from lexstack.mpc.hard_limits import HeldLimits
from lexstack.mpc.stage_kinematics import StageKinematics, StageModel
from lexstack.mpc.tracking_objectives import Task
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Iterate:
    """Inputs and what follows from them.

    Attributes:
        u: shape (N, n).
        q: states 0 to N, shape (N + 1, n_q).
        v: likewise, shape (N + 1, n).
        at: kinematics at the states 1 to N.
        shared_cost: effort and barriers: the part of the cost that all levels share.
    """

    u: Matrix
    q: Matrix
    v: Matrix
    at: StageKinematics
    shared_cost: float


@dataclass(frozen=True, slots=True, eq=False)
class Quadratic:
    """The cost of a level near an iterate, by stages: what the states cost, not yet condensed.

    Attributes:
        gradient: by the inputs, shape (N n,).
        coupled: Gauss-Newton Hessian of task and distances by the q of the states 1 to N, shape
            (N, n_q, n_q).
        barriers: diagonals of the barriers of the limits by q (the last n of n_q), v and u, shapes
            (N, n).
        sensitivity: how q follows the inputs.
        program: whose cost it is.
    """

    gradient: Vector
    coupled: Array
    barriers: tuple[Matrix, ...]
    sensitivity: Sensitivity
    program: Program

    @property
    def hessian(self) -> Matrix:
        """The condensed Gauss-Newton Hessian, shape (N n, N n); a new array."""
        positions, velocities, inputs = self.barriers
        stages, n = positions.shape
        curved = self.coupled.copy()
        size = curved.shape[1]
        first = size - n
        curved.reshape(stages, size * size)[:, first * (size + 1) :: size + 1] += positions
        return self.program.condensed(self.sensitivity.condensed(curved), velocities, inputs)


class Program:
    """One H(9), without the task: from a state, with the input before it.

    Attributes:
        horizon: the dynamics.
        effort: H(10).
        hard: limits as constraints, or None.
    """

    def __init__(
        self,
        horizon: Horizon,
        model: StageModel,
        effort: Effort,
        barrier: LimitBarrier,
        *,
        collisions: Collisions,
        hard: HeldLimits | None,
        start: tuple[Vector, Vector, Vector],
    ) -> None:
        """Take the parts, and q, v and u_{-1}, shapes (n_q,), (n,) and (n,)."""
        self.horizon = horizon
        self.hard = hard
        self.collisions = collisions
        self._model = model
        self.effort = effort
        self._barrier = barrier
        self._q, self._v, self._previous = start
        # Of a differential base, x is beyond what follows; y and yaw stand in for the positions of
        # v and w, which have none, and no limits either. So the last n of q go with chi.
        self._first = len(self._q) - len(self._v)

    @property
    def differential(self) -> bool:
        """Whether the robot is on a differential base: then joints couple in its dynamics."""
        return self._first > 0

    def iterate(self, u: Matrix) -> Iterate:
        """Roll out inputs of shape (N, n)."""
        q, v = self.horizon.roll_out(self._q, self._v, u)
        at = self._model.at(q[1:])
        shared_cost = self.effort.value(v[1:], u, self._previous)
        shared_cost += self._barrier.value(q[1:, self._first :], v[1:], u)
        if self.collisions.active:
            shared_cost += self.collisions.value(at)
        return Iterate(u, q, v, at, shared_cost)

    def sensitivity(self, iterate: Iterate) -> Sensitivity:
        """Return how the positions follow the inputs at an iterate."""
        return self.horizon.sensitivity(self._q, self._v, iterate.u)

    def kinematics(self, u: Matrix) -> StageKinematics:
        """Return where inputs of shape (N, n) lead, at the states 1 to N."""
        return self._model.at(self.horizon.roll_out(self._q, self._v, u)[0][1:])

    def cost(self, iterate: Iterate, task: Task) -> float:
        """Return J_l + J_eff + barriers, H(9a)."""
        return iterate.shared_cost + task.cost_at(iterate.at)

    def quadratic(self, iterate: Iterate, task: Task) -> Quadratic:
        """Return the cost of a level near an iterate; only the joints that the task may move."""
        q, v, u, at = iterate.q[1:], iterate.v[1:], iterate.u, iterate.at
        first = self._first
        slope, curvature = self._barrier.slopes(q[:, first:], v, u)
        jacobian = task.jacobian(at)
        weighted = task.weights[:, :, None] * jacobian
        along_q = (task.error(at)[:, None] @ weighted)[:, 0]
        along_q[:, first:] += slope[0]
        curved = jacobian.transpose(0, 2, 1) @ weighted
        if self.collisions.active:
            push, stiffness = self.collisions.slopes(at)
            along_q += push
            curved += stiffness
        sensitivity = self.sensitivity(iterate)
        gradient = sensitivity.gradient(along_q)
        gradient += self.horizon.to_velocity.T @ (slope[1])
        gradient += slope[2]
        gradient += self.effort.gradient(v, u, self._previous)
        if task.moving is not None:
            gradient *= task.moving
            moving = np.concatenate((task.moving[:first], task.moving))  # x with the rest of a base
            curved *= moving[:, None] * moving
            curvature = (curvature[0] * task.moving, *curvature[1:])
        return Quadratic(gradient.reshape(-1), curved, curvature, sensitivity, self)

    def condensed(self, full: Matrix, velocity: Matrix, inputs: Matrix) -> Matrix:
        """Return the condensed Hessian; what comes from the positions (N N, n n) is overwritten.

        ``velocity`` and ``inputs`` are the curvatures in v and u, shape (N, n).
        """
        # H_ij = sum_k S_ki' B_k S_kj + D_ki D_kj V_k (+ U_i where i = j): row i N + j of ``full``
        # is the block of stages i and j, before the last line sorts by (stage, joint). V, U and
        # the effort act on each joint alone: they enter the diagonals.
        stages, n = inputs.shape
        diagonal = full.reshape(stages, stages, n * n)[:, :, :: n + 1]
        diagonal += (self.horizon.velocity_products @ velocity).reshape(stages, stages, n)
        diagonal += self.effort.hessian
        same = np.arange(stages)
        diagonal[same, same] += inputs
        hessian = full.reshape(stages, stages, n, n).transpose(0, 2, 1, 3)
        return hessian.reshape(stages * n, stages * n)
