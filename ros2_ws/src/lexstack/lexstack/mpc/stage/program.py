"""H(9) of all levels with compiled costs: a trial of a line search is one call, a QP's data two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.barriers import LimitBarrier
from lexstack.mpc.collision_cost import Collisions
from lexstack.mpc.double_integrator import Horizon, Sensitivity
from lexstack.mpc.effort import Effort
from lexstack.mpc.hard_limits import HeldLimits
from lexstack.mpc.level_problem import Iterate, Program, Quadratic
from lexstack.mpc.measures import Kind, Measure
from lexstack.mpc.options import HtmpcConfig
from lexstack.mpc.stage.kernel.values import (
    BASE_POSE,
    COORDINATES,
    ORIENTATION,
    POSE,
    POSITION,
    REFERENCE,
    ROW,
    ROWS,
    Limits,
    Places,
    Scene,
    Tasks,
)
from lexstack.mpc.stage.model import CompiledStageModel, CompiledStages
from lexstack.mpc.stage.sensitivity import NO_DRIVE, sensitivity_of
from lexstack.mpc.tracking_objectives import Task
from lexstack.mpc.unicycle_horizon import QUADRATURE, UnicycleSensitivity
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]

_KINDS: dict[Kind, int] = {
    "ee_position": POSITION,
    "ee_pose": POSE,
    "ee_orientation": ORIENTATION,
    "base_position": COORDINATES,
    "base_pose": BASE_POSE,
    "joint_positions": COORDINATES,
}


@dataclass(frozen=True, slots=True, eq=False)
class Costs:
    """What does not change from solve to solve: barriers before limits, effort, and both as arrays.

    Attributes:
        barrier: of the limits.
        effort: of the inputs.
        limits: both, and the settings of the barriers.
    """

    barrier: LimitBarrier
    effort: Effort
    limits: Limits

    @classmethod
    def of(cls, config: HtmpcConfig, barrier: LimitBarrier, effort: Effort) -> Costs:
        """Return them as arrays, too."""
        bounded = barrier.bounded.astype(np.int64)
        limits, collision = config.limits, config.collision
        reach = collision.influence - collision.margin if collision.influence else np.inf
        settings = np.array([limits.mu, limits.zeta, collision.mu, collision.zeta, reach])
        weights = np.stack((effort.velocity, effort.input, effort.change))
        laid_out = Limits(bounded, barrier.lower, barrier.upper, weights, settings)
        return cls(barrier, effort, laid_out)


class CompiledQuadratic(Quadratic):
    """As ``Quadratic``, condensed by compiled code."""

    __slots__ = ()

    @property
    def hessian(self) -> Matrix:
        """The condensed Gauss-Newton Hessian, shape (N n, N n); a new array."""
        assert isinstance(self.program, CompiledProgram)
        return self.program.full(self)


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
        self._chain, self._empty, self._compiled = model.chain, model.empty, model
        self._limits = costs.limits
        self._scene = scene_of(collisions, horizon.stages)
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
            *self._chain,
            *self._limits,
            *self._scene,
            *layout_of(task.measure, self._model.frames),
            task.weights,
            task.error(iterate.at),
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
        sensitivity = self.sensitivity(iterate)
        gradient = np.empty((stages, n))
        self._gradient(slant, forces, drive_of(sensitivity), self.horizon.step, gradient)
        if task.moving is not None:
            gradient *= task.moving
            moving = np.concatenate((task.moving[: size - n], task.moving))
            coupled *= moving[:, None] * moving
            stiffness[0] *= task.moving
        return CompiledQuadratic(gradient.reshape(-1), coupled, tuple(stiffness), sensitivity, self)

    def sensitivity(self, iterate: Iterate) -> Sensitivity:
        """Return how the positions follow the inputs at an iterate."""
        return sensitivity_of(self.horizon, iterate.q, iterate.v, iterate.u)

    def full(self, quadratic: Quadratic) -> Matrix:
        """Return the condensed Hessian, shape (N n, N n)."""
        stages, n = quadratic.barriers[0].shape
        hessian = np.empty((stages * n, stages * n))
        stiffness, drive = np.stack(quadratic.barriers), drive_of(quadratic.sensitivity)
        effort, step = self._limits.effort, self.horizon.step
        self._full(quadratic.coupled, stiffness, effort, drive, step, hessian)
        return hessian

    def _evaluated(self, u: Matrix) -> tuple[Matrix, Matrix, CompiledStages, float]:
        """Return q, v, kinematics and the shared cost; the tasks' errors are found there."""
        stages = len(u)
        q, v = np.empty((stages + 1, self._q.size)), np.empty((stages + 1, self._v.size))
        q[0], v[0] = self._q, self._v
        at = self._empty()
        tasks = self._laid_out
        errors, costs = np.empty(tasks.weights.size), np.empty(1 + len(self._tasks))
        self._evaluate(
            *self._chain,
            *self._limits,
            *self._scene,
            *tasks,
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


def drive_of(sensitivity: Sensitivity) -> Array:
    """Return how x and y of a differential base follow its inputs, shape (N, 2, N, 2) or none."""
    return sensitivity.drive if isinstance(sensitivity, UnicycleSensitivity) else NO_DRIVE


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


def scene_of(collisions: Collisions, stages: int) -> Scene:
    """Return what spheres keep off as arrays; none where nothing is to be kept off."""
    if not collisions.active:
        return _nothing_around(stages)
    around = collisions.around
    centers = np.zeros((stages, 0, 3)) if around is None else around.centers
    return Scene(
        np.ascontiguousarray(centers, dtype=float),
        collisions.reach,
        collisions.lifted.astype(np.int64),
        collisions.height,
    )


@cache
def _nothing_around(stages: int) -> Scene:
    """Return a scene in which no sphere keeps off anything."""
    return Scene(
        np.zeros((stages, 0, 3)), np.zeros((0, 0)), np.zeros(0, dtype=np.int64), np.zeros(0)
    )


@lru_cache(maxsize=256)
def layout_of(measure: Measure, frames: tuple[str, ...]) -> tuple[Places, Places]:
    """Return the layout of a task as if it were alone, shape (5,), and its coordinates, (s,)."""
    point = frames.index(measure.frame) if measure.frame else -1
    layout = np.array([_KINDS[measure.kind], point, measure.rows, 0, 0], dtype=np.int64)
    places = measure.places or (0,) * measure.rows
    return layout, np.array(places, dtype=np.int64)


@lru_cache(maxsize=256)
def layouts_of(measures: tuple[Measure, ...], frames: tuple[str, ...]) -> tuple[Places, Places]:
    """Return the layouts of tasks, shape (T, 5), and the coordinates of all their rows."""
    each = [layout_of(measure, frames) for measure in measures]
    layout = np.array([one for one, _ in each], dtype=np.int64).reshape(-1, 5)
    layout[1:, ROW] = np.cumsum(layout[:-1, ROWS])
    layout[1:, REFERENCE] = np.cumsum([measure.columns for measure in measures[:-1]])
    return layout, np.array([place for _, places in each for place in places], dtype=np.int64)


def tasks_of(tasks: Sequence[Task], frames: tuple[str, ...]) -> Tasks:
    """Return tasks as arrays."""
    layout, places = layouts_of(tuple(task.measure for task in tasks), frames)
    if not tasks:
        return Tasks(layout, places, np.zeros(0), np.zeros(0))
    return Tasks(
        layout,
        places,
        np.concatenate([task.reference.ravel() for task in tasks], dtype=float),
        np.concatenate([task.weights.ravel() for task in tasks]),
    )
