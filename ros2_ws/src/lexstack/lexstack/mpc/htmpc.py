"""HTMPC, Algorithm 2: levels in order, none of which may spoil one above it."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from lexstack.errors import InputError, ModelError
from lexstack.mpc.barriers import LimitBarrier
from lexstack.mpc.collision_cost import Collisions, CollisionScene
from lexstack.mpc.double_integrator import Horizon
from lexstack.mpc.effort import Effort
from lexstack.mpc.hard_limits import HardLimits
from lexstack.mpc.level_problem import Iterate, Program
from lexstack.mpc.level_sqp import Level
from lexstack.mpc.lexicographic_constraints import LexicographicConstraint
from lexstack.mpc.limited_qp import EMPTY, ActiveSet
from lexstack.mpc.options import HtmpcConfig
from lexstack.mpc.plan import Plan
from lexstack.mpc.stage_kinematics import StageModel
from lexstack.mpc.status import LevelStatus, Outcome
from lexstack.mpc.tracking_objectives import Objective, Task
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """The state that a plan starts from: measured, never an integral of commands.

    Attributes:
        stamp: s.
        q: shape (n,), m and rad.
        v: shape (n,), m/s and rad/s, base in the world frame.
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
            ModelError: the robot has no base, or a joint or a sphere that cannot be.
        """
        if not robot.has_base:
            raise ModelError(f"robot {robot.name}: has no base, and the MPC needs one")
        if robot.differential:
            raise ModelError(
                f"robot {robot.name}: its base is differential, the MPC's is holonomic"
            )
        chosen = tuple(range(len(robot.config.spheres))) if spheres is None else spheres
        limits = robot.limits
        self.config = config
        self.robot = robot
        self.horizon = Horizon(config.horizon, config.step)
        self._model = StageModel(robot, config.horizon, ())
        self._model_with_spheres = StageModel(robot, config.horizon, chosen)
        # The floor is there for a lone robot without obstacles, too.
        self._floor = config.collision.ground and bool(self._model_with_spheres.lifted.any())
        self._effort = Effort(config.effort, self.horizon, robot.n)
        self._barrier = LimitBarrier(
            config.limits,
            (limits.position_lower, limits.position_upper),
            limits.velocity,
            limits.acceleration,
        )
        self._hard = HardLimits(limits, self.horizon) if config.hard_limits else None

    def solve(
        self,
        start: Start,
        objectives: tuple[Objective, ...],
        before: Plan | None = None,
        around: CollisionScene | None = None,
    ) -> Plan:
        """Return the plan from a state.

        Args:
            start: the measured state.
            objectives: the tasks of the window, highest first.
            before: the plan that was in force until now: first guess and u_{-1}.
            around: what is in the way beside the floor; None: nothing.

        Raises:
            InputError: a shape or value that is wrong; what a solver does is in the status.
        """
        begun = perf_counter()
        self._check(start, objectives)
        tasks = [Task(objective, self.config, self.robot.n) for objective in objectives]
        program = self.program(start, before, around)
        iterate = program.iterate(self._guess(start, tasks, before, program))
        levels, active_sets, iterate = self._solve_levels(program, tasks, iterate, before)
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
        at = self._model_with_spheres.at(q)
        return CollisionScene(at.centers, self._model_with_spheres.radii)

    def _solve_levels(
        self, program: Program, tasks: list[Task], iterate: Iterate, before: Plan | None
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
            level = Level(self.config, program, task, tuple(constraints), guess)
            if i and self.config.restart_from_previous:
                iterate = level.better(iterate, guessed)
            iterate, status = level.solve(iterate)
            active_sets.append(level.active_set)
            levels.append(status)
            best = task.error(iterate.at)
            constraints.append(
                LexicographicConstraint(i, task, best, self.config.lexicographic, self.horizon)
            )
        return levels, tuple(active_sets), iterate

    def program(
        self, start: Start, before: Plan | None = None, around: CollisionScene | None = None
    ) -> Program:
        """Return what all levels of a solve share; arguments as in ``solve``."""
        model = self._model if around is None and not self._floor else self._model_with_spheres
        previous = np.zeros(self.robot.n) if before is None else before.input_before(start.stamp)
        return Program(
            self.horizon,
            model,
            self._effort,
            self._barrier,
            collisions=Collisions(self.config.collision, model, around),
            hard=None if self._hard is None else self._hard.at(start.q, start.v),
            start=(start.q, start.v, previous),
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
        for name, value in (("q", start.q), ("v", start.v)):
            if value.shape != (self.robot.n,) or not np.isfinite(value).all():
                raise InputError(
                    f"htmpc: {name} of shape {value.shape}, expected {self.robot.n} finite numbers"
                )
        if not objectives:
            raise InputError("htmpc: at least one task is needed")


def _skipped(level: int, task: Task, iterate: Iterate) -> LevelStatus:
    """Return the status of a level that was not tried."""
    cost = task.cost_at(iterate.at)
    name = task.objective.name
    return LevelStatus(level, name, Outcome.SKIPPED, 0, (), 0, "", "not tried", cost, 0.0)
