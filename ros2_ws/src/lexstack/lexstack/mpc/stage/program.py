"""H(9) of all levels with compiled costs: a trial of a line search is one call, a QP's data two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.collision_cost import Collisions
from lexstack.mpc.double_integrator import Horizon, Sensitivity
from lexstack.mpc.hard_limits import HeldLimits
from lexstack.mpc.level_problem import Iterate, Program, Quadratic
from lexstack.mpc.stage import sensitivity
from lexstack.mpc.stage.arrays import Costs, layout_of, scene_of, tasks_of
from lexstack.mpc.stage.model import CompiledStageModel, CompiledStages
from lexstack.mpc.tracking_objectives import Task
from lexstack.mpc.unicycle_horizon import QUADRATURE, UnicycleSensitivity
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class CompiledQuadratic(Quadratic):
    """As ``Quadratic``, condensed by compiled code.

    Attributes:
        stiffness: the ``barriers`` as one array, shape (3, N, n).
    """

    stiffness: Array

    @property
    def hessian(self) -> Matrix:
        """The condensed Gauss-Newton Hessian, shape (N n, N n); a new array."""
        assert isinstance(self.program, CompiledProgram)
        return self.program.full(self.coupled, self.stiffness, self.sensitivity)


class CompiledProgram(Program):
    """As ``Program``, whose equations it has in compiled code; needs numba."""

    def __init__(
        self,
        horizon: Horizon,
        model: CompiledStageModel,
        costs: Costs,
        *,
        collisions: Collisions,
        hard: HeldLimits | None,
        start: tuple[Vector, Vector, Vector],
        tasks: Sequence[Task] = (),
    ) -> None:
        """Take the parts, q, v and u_{-1}, and the tasks whose errors all iterates shall have."""
        super().__init__(
            horizon,
            model,
            costs.effort,
            costs.barrier,
            collisions=collisions,
            hard=hard,
            start=start,
        )
        self._empty, self._compiled = model.empty, model
        self._limits = costs.limits
        scene = scene_of(collisions, horizon.stages)
        self._fixed = (*model.chain, *costs.limits, *scene)
        self._tasks = tuple(tasks)
        self._laid_out = tasks_of(self._tasks, model.frames)
        self._evaluate, self._curve, self._gradient, self._full = _entries()

    def iterate(self, u: Matrix) -> Iterate:
        """Roll out inputs of shape (N, n)."""
        q, v, at, shared_cost = self._evaluated(u)
        return Iterate(u, q, v, at, shared_cost)

    def kinematics(self, u: Matrix) -> CompiledStages:
        """Return where inputs of shape (N, n) lead, at the states 1 to N."""
        return self._evaluated(u)[2]

    def quadratic(self, iterate: Iterate, task: Task) -> Quadratic:
        """Return the cost of a level near an iterate; only the joints that the task may move."""
        assert isinstance(iterate.at, CompiledStages)
        (stages, n), size = iterate.u.shape, iterate.q.shape[1]
        slant, coupled = np.empty((stages, size)), np.empty((stages, size, size))
        forces, stiffness = np.empty((2, stages, n)), np.empty((3, stages, n))
        self._curve(
            *self._fixed,
            *layout_of(task.measure, self._model.frames),
            task.weights,
            np.ascontiguousarray(task.error(iterate.at)),
            iterate.q,
            iterate.v,
            np.ascontiguousarray(iterate.u),
            self._previous,
            *iterate.at.stages,
            slant,
            coupled,
            forces,
            stiffness,
        )
        along = self.sensitivity(iterate)
        gradient = np.empty((stages, n))
        self._gradient(slant, forces, drive_of(along), self.horizon.step, gradient)
        if task.moving is not None:
            gradient *= task.moving
            moving = np.concatenate((task.moving[: size - n], task.moving))
            coupled *= moving[:, None] * moving
            stiffness[0] *= task.moving
        barriers = stiffness[0], stiffness[1], stiffness[2]
        return CompiledQuadratic(gradient.reshape(-1), coupled, barriers, along, self, stiffness)

    def sensitivity(self, iterate: Iterate) -> Sensitivity:
        """Return how the positions follow the inputs at an iterate."""
        return sensitivity.sensitivity_of(self.horizon, iterate.q, iterate.v, iterate.u)

    def full(self, coupled: Array, stiffness: Array, along: Sensitivity) -> Matrix:
        """Return the condensed Hessian, shape (N n, N n); see ``CompiledQuadratic``."""
        size = stiffness[0].size
        hessian = np.empty((size, size))
        effort, step = self._limits.effort, self.horizon.step
        self._full(coupled, stiffness, effort, drive_of(along), step, hessian)
        return hessian

    def _evaluated(self, u: Matrix) -> tuple[Matrix, Matrix, CompiledStages, float]:
        """Return q, v, kinematics and the shared cost; the tasks' errors are found there."""
        stages = len(u)
        q, v = np.empty((stages + 1, self._q.size)), np.empty((stages + 1, self._v.size))
        q[0], v[0] = self._q, self._v
        at = self._empty()
        errors, costs = np.empty(self._laid_out.weights.size), np.empty(1 + len(self._tasks))
        self._evaluate(
            *self._fixed,
            *self._laid_out,
            self.horizon.step,
            QUADRATURE,
            self._previous,
            np.ascontiguousarray(u),
            q,
            v,
            *at,
            errors,
            costs,
        )
        found = CompiledStages(self._compiled, q[1:], at)
        errors.setflags(write=False)
        begin = 0
        for task, cost in zip(self._tasks, costs[1:].tolist(), strict=True):
            end = begin + task.weights.size
            found.found[task] = errors[begin:end].reshape(task.weights.shape), cost
            begin = end
        return q, v, found, float(costs[0])


def drive_of(found: Sensitivity) -> Array:
    """Return how x and y of a differential base follow its inputs, shape (N, 2, N, 2) or none."""
    return found.drive if isinstance(found, UnicycleSensitivity) else sensitivity.NO_DRIVE


def load() -> None:
    """Load all compiled code, which takes tenths of a second, before a solve needs it."""
    _entries()
    sensitivity.entries()


@cache
def _entries() -> tuple[Any, ...]:
    """Return the compiled functions; the first call loads numba."""
    from lexstack.mpc.stage.kernel import condensing, curvature, evaluation  # noqa: PLC0415

    return (
        evaluation.evaluate,
        curvature.curve,
        condensing.condense_gradient,
        condensing.condense_hessian,
    )
