"""HTMPC, Algorithm 2: levels in order, none of which may spoil one above it."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from lexstack.compiled import available
from lexstack.errors import InputError
from lexstack.mpc.barriers import LimitBarrier
from lexstack.mpc.collision_cost import Collisions, CollisionScene
from lexstack.mpc.double_integrator import Horizon
from lexstack.mpc.effort import Effort
from lexstack.mpc.hard_limits import HardLimits
from lexstack.mpc.iteration_clock import IterationClock
from lexstack.mpc.level_problem import Iterate, Program
from lexstack.mpc.level_sqp import Level
from lexstack.mpc.lexicographic_constraints import LexicographicConstraint
from lexstack.mpc.limited_qp import EMPTY, ActiveSet
from lexstack.mpc.measures import Measure, Subject, measure_of
from lexstack.mpc.options import HtmpcConfig
from lexstack.mpc.other_robots import OtherRobot, scene_of
from lexstack.mpc.plan import Plan
from lexstack.mpc.stage.arrays import Costs
from lexstack.mpc.stage.model import CompiledStageModel
from lexstack.mpc.stage.program import CompiledProgram, load
from lexstack.mpc.stage_kinematics import StageModel
from lexstack.mpc.status import LevelStatus, Outcome
from lexstack.mpc.structured_qp import load_kernel
from lexstack.mpc.tracking_objectives import Objective, Task
from lexstack.mpc.unicycle_horizon import UnicycleHorizon
from lexstack.mpc.unicycle_lead import UnicycleLead
from lexstack.robots import RobotModel
from lexstack.robots.assembly import TOOL
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """The state that a plan starts from: measured, never an integral of commands.

    Attributes:
        stamp: s.
        q: shape (n_q,), m and rad.
        v: shape (n,), m/s and rad/s; of a holonomic base in the world frame.
    """

    stamp: float
    q: Vector
    v: Vector


class Htmpc:
    """The optimiser of one robot. It keeps buffers, but no memory from solve to solve.

    Attributes:
        config: its parameters.
        robot: the model.
        horizon: the dynamics, and the times at which references are wanted.
    """

    def __init__(
        self, robot: RobotModel, config: HtmpcConfig, spheres: tuple[int, ...] | None = None
    ) -> None:
        """Generate the code, condense what is constant.

        Args:
            robot: its model.
            config: parameters.
            spheres: places in the robot's list of those that keep distances, also to the floor
                where the configuration says so; None: all.

        Raises:
            ModelError: the robot has a joint or a sphere that cannot be.
        """
        chosen = tuple(range(len(robot.config.spheres))) if spheres is None else spheres
        limits = robot.limits
        self.config = config
        self.robot = robot
        horizon = UnicycleHorizon if robot.differential else Horizon
        self.horizon = horizon(config.horizon, config.step)
        self._lead = UnicycleLead(robot, config.step) if robot.differential else None
        self._spheres = chosen
        self._kind = _model_kind(config)
        self._models: dict[tuple[tuple[str, ...], bool], StageModel] = {}
        # The floor is there for a lone robot without obstacles, too.
        self._floor = config.collision.ground and bool(self._model((TOOL,), True).lifted.any())
        self._model((TOOL,), self._floor)
        barrier = LimitBarrier(
            config.limits,
            (limits.position_lower, limits.position_upper),
            limits.velocity,
            limits.acceleration,
        )
        effort = Effort(config.effort, self.horizon, robot.n, robot.arm.start)
        self._costs = Costs.of(config, barrier, effort)
        self._hard = HardLimits(limits, self.horizon) if config.hard_limits else None
        if config.qp == "structured" and not robot.differential:
            load_kernel()

    def solve(
        self,
        start: Start,
        objectives: tuple[Objective, ...],
        before: Plan | None = None,
        around: CollisionScene | None = None,
        others: Iterable[OtherRobot] = (),
    ) -> Plan:
        """Return the plan from a state.

        Args:
            start: the measured state.
            objectives: the tasks of the window, highest first.
            before: the plan that was in force until now: first guess and u_{-1}.
            around: what is in the way beside the floor; None: nothing.
            others: other robots, which are avoided where they will be.

        Raises:
            InputError: a shape or value that is wrong; what a solver does is in the status.
        """
        begun = perf_counter()
        clock = IterationClock(self.config.deadline)
        self._check(start, objectives)
        state = start.q, start.v
        tasks = [
            Task(objective, self.config, self.robot, self._lead, state) for objective in objectives
        ]
        scene = scene_of(others, start.stamp, start.stamp + self.horizon.times[1:])
        if scene is not None:
            around = scene if around is None else around.joined(scene)
        program = self.program(start, before, around, frames_of(tasks), tasks)
        iterate = program.iterate(self._guess(start, tasks, before, program))
        iterate = _led(program, tasks[0], iterate)
        levels, active_sets, iterate = self._solve_levels(program, tasks, iterate, before, clock)
        return Plan(
            stamp=start.stamp,
            step=self.config.step,
            q=iterate.q,
            v=iterate.v,
            u=iterate.u,
            levels=tuple(levels),
            errors=tuple(task.error(iterate.at) for task in tasks),
            active_sets=active_sets,
            solve_time=perf_counter() - begun,
        )

    def obstacles(self, q: Matrix) -> CollisionScene:
        """Return this robot's spheres as what is in another robot's way.

        Args:
            q: where it will be at the states 1 to N of the other one, shape (N, n).
        """
        model = self._model((), True)
        return CollisionScene(model.at(q).centers, model.radii)

    def prepare(self, windows: Iterable[tuple[Subject, ...]]) -> None:
        """Generate the kinematics that tasks will need together: 10 to 30 ms each, once.

        Without it the first solve of a new set of frames takes so much longer.

        Raises:
            InputError: the robot has no such frame, joint or base.
        """
        for window in windows:
            measures = [measure_of(subject, self.robot) for subject in window]
            frames = frames_of(measures)
            for spheres in {True, self._floor}:
                self._model(frames, spheres)

    def _model(self, frames: tuple[str, ...], spheres: bool) -> StageModel:
        """Return the kinematics of some frames, with all chosen spheres or none."""
        key = frames, spheres
        if key not in self._models:
            chosen = self._spheres if spheres else ()
            self._models[key] = self._kind(self.robot, self.config.horizon, chosen, frames)
        return self._models[key]

    def _solve_levels(
        self,
        program: Program,
        tasks: list[Task],
        iterate: Iterate,
        before: Plan | None,
        clock: IterationClock,
    ) -> tuple[list[LevelStatus], tuple[ActiveSet, ...], Iterate]:
        """Solve all levels in order; what comes below a failure is skipped."""
        constraints: list[LexicographicConstraint] = []
        levels: list[LevelStatus] = []
        guessed = iterate
        known = () if before is None else before.active_sets
        active_sets: list[ActiveSet] = []
        for i, task in enumerate(tasks):
            if levels and not levels[-1].outcome.sound:
                levels.append(_skipped(i, task, iterate))
                continue
            guess = known[i] if i < len(known) else EMPTY
            level = Level(self.config, program, task, tuple(constraints), guess, clock)
            if i and self.config.restart_from_previous:
                iterate = level.better(iterate, guessed)
            iterate, status = level.solve(iterate)
            active_sets.append(level.active_set)
            levels.append(status)
            best = task.error(iterate.at)
            constraints.append(LexicographicConstraint(i, task, best, self.config.lexicographic))
        return levels, tuple(active_sets), iterate

    def program(
        self,
        start: Start,
        before: Plan | None = None,
        around: CollisionScene | None = None,
        frames: tuple[str, ...] = (TOOL,),
        tasks: Sequence[Task] = (),
    ) -> Program:
        """Return what all levels of a solve share, for tasks of ``frames``; see ``solve``.

        The errors of the ``tasks`` are computed with every iterate, where that is compiled.
        """
        robot, model = self.robot, self._model(frames, self._floor or around is not None)
        previous = np.zeros(robot.n) if before is None else before.input_before(start.stamp)
        hard = None if self._hard is None else self._hard.at(start.q[-robot.n :], start.v)
        collisions = Collisions(self.config.collision, model, around)
        state = start.q, start.v, previous
        if isinstance(model, CompiledStageModel):
            return CompiledProgram(
                self.horizon,
                model,
                self._costs,
                collisions=collisions,
                hard=hard,
                start=state,
                tasks=tasks,
            )
        return Program(
            self.horizon,
            model,
            self._costs.effort,
            self._costs.barrier,
            collisions=collisions,
            hard=hard,
            start=state,
        )

    def _guess(
        self, start: Start, tasks: list[Task], before: Plan | None, program: Program
    ) -> Matrix:
        """Return the first inputs, shape (N, n): the plan before, shifted; or braking."""
        masks = [task.moving for task in tasks if task.moving is not None]
        apart = len(masks) == len(tasks)
        if before is not None and not apart:
            u = before.shifted(start.stamp)
        else:
            braking = self.horizon.braking(start.v, self.robot.limits.acceleration)
            u = braking if before is None else before.shifted(start.stamp)
            if apart:
                resting = np.max(masks, axis=0) == 0.0
                u[:, resting] = braking[:, resting]
        return u if program.hard is None else program.hard.repaired(u)

    def _check(self, start: Start, objectives: tuple[Objective, ...]) -> None:
        """Raise InputError for a state that cannot be, or no task at all."""
        robot = self.robot
        for name, value, size in (("q", start.q, robot.nq), ("v", start.v, robot.n)):
            if value.shape != (size,) or not np.isfinite(value).all():
                raise InputError(
                    f"htmpc: {name} of shape {value.shape}, expected {size} finite numbers"
                )
        if not objectives:
            raise InputError("htmpc: at least one task is needed")


def _model_kind(config: HtmpcConfig) -> type[StageModel]:
    """Return whether kinematics, and with them all costs, are compiled."""
    if config.evaluation == "plain":
        return StageModel
    if available():
        load()
        return CompiledStageModel
    warnings.warn("numba is not installed: the MPC's costs are computed without it", stacklevel=3)
    return StageModel


def _led(program: Program, task: Task, iterate: Iterate) -> Iterate:
    """Return the first iterate, or one with the motion that leads a base, if that costs less.

    At rest beside its goal a differential base would otherwise have no descent.
    """
    if task.inputs is None:
        return iterate
    u = iterate.u.copy()
    u[:, : task.inputs.shape[1]] = task.inputs
    other = program.iterate(u if program.hard is None else program.hard.repaired(u))
    return other if program.cost(other, task) < program.cost(iterate, task) else iterate


def frames_of(tasks: Iterable[Task | Measure]) -> tuple[str, ...]:
    """Return the frames of some tasks, each once, in the order of the alphabet."""
    return tuple(sorted({task.frame for task in tasks if task.frame}))


def _skipped(level: int, task: Task, iterate: Iterate) -> LevelStatus:
    """Return the status of a level that was not tried."""
    cost = task.cost_at(iterate.at)
    name = task.objective.name
    return LevelStatus(level, name, Outcome.SKIPPED, 0, (), 0, "", "not tried", cost, 0.0)
