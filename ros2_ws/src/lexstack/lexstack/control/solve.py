"""One call for one velocity: a stack solved at a configuration, within the robot's limits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from lexstack.control.controller import checked
from lexstack.control.kernels import load_kernels
from lexstack.errors import InputError
from lexstack.hqp import (
    DEFAULT_SOLVER,
    Damper,
    HqpProblem,
    Solution,
    describe,
    explain_unmet_levels,
    make_solver,
    near_singularity,
)
from lexstack.limits.joint_limits import Bounds
from lexstack.limits.viable_bounds import target_bounds, viable_bounds
from lexstack.references import Motion, References, Trajectory, Twist
from lexstack.robots import Configuration, Pose, Team
from lexstack.tasks.posture import Posture
from lexstack.tasks.specs.compiled import Aim, Compiled, Names, compiled
from lexstack.tasks.specs.stack import Stack
from lexstack.types import Vector

_MOST = 16  # robots, periods and obstacles that a stack is kept ready for
_AT = 1e-9  # m/s, rad/s: nearer to its bound a joint is at it


@dataclass(frozen=True, eq=False)
class HqpResult:
    """The velocity that a stack asks for, and how far each level is from what it wants.

    Attributes:
        velocity: shape (n_v,), m/s and rad/s; inside ``bounds``, whatever the solver did.
        residuals: norm of each level's residual, the highest first; 0: met.
        bounds: the box that was kept: position and velocity limits, and the acceleration limits
            where the configuration has a velocity.
        failure: empty, or why the velocity brakes or is another solver's.
        problem: the levels made linear at the configuration.
        solution: of the problem; ``near`` names levels near a singularity.
        joints: names of the joints, in the order of the velocity.
    """

    velocity: Vector
    residuals: Vector
    bounds: Bounds
    failure: str
    problem: HqpProblem
    solution: Solution
    joints: tuple[str, ...]

    @cached_property
    def unmet(self) -> str:
        """Which levels are not met, by how much, and what holds them, in words; empty: all met."""
        if not self.solution.solved:
            return self.failure
        levels = describe(explain_unmet_levels(self.problem, self.solution), self.joints)
        near = near_singularity(self.solution.near)
        return "; ".join(words for words in (levels, near) if words)

    @property
    def at_limits(self) -> tuple[str, ...]:
        """The joints whose velocity is at an end of its bounds."""
        low = self.velocity - self.bounds.lower <= _AT
        high = self.bounds.upper - self.velocity <= _AT
        return tuple(name for name, at in zip(self.joints, low | high, strict=True) if at)


class HqpController:
    """A stack made ready for robots and a period: ``solve`` in a loop, at microseconds' cost.

    ``solve_hqp`` makes one where there is none, and keeps it with the stack.
    """

    def __init__(
        self, team: Team, stack: Stack, dt: float, *, solver: str = DEFAULT_SOLVER
    ) -> None:
        """Make the stack's tasks for these robots.

        Args:
            team: whose robots and obstacles count.
            stack: levels of tasks.
            dt: control period [s].
            solver: a key of ``SOLVERS``.

        Raises:
            ConfigurationError: the stack does not fit the robots; the text names the task.
            InputError: the period is not positive.
        """
        if not 0.0 < dt < np.inf:
            raise InputError(f"dt: must be finite and > 0, got {dt}")
        load_kernels()
        self._team = Team(team.robots, dt, team.obstacles)
        self._compiled: Compiled = compiled(stack, self._team, Names())
        self._limits = self._compiled.stack.limits or self._team.limits
        self._solver = make_solver(solver)
        self._damper = Damper(self._team, dt)
        self._warm: Solution | None = None

    def solve(self, configuration: Configuration) -> HqpResult:
        """Return the velocity at a configuration; what a solver does is in the result."""
        kinematics, dt = configuration.kinematics, self._team.dt
        state = kinematics.state
        references = references_of(self._compiled.aims, configuration, 0.5 * dt)
        for aim in self._compiled.aims:
            if isinstance(aim.task, Posture):
                aim.task.led = aim.spec.revision > 0
        levels = self._compiled.stack.linearise(kinematics, references)
        place = self._team.joint_positions(state.q_star)
        if configuration.bounded:
            bounds = viable_bounds(place, self._limits, dt, state.command)
        else:
            bounds = target_bounds(place, self._limits, dt)
        problem = HqpProblem(levels, bounds)
        damped = self._damper.damped(problem, kinematics, self._limits)
        solution = damped.own(self._solver.solve(damped.problem, damped.warm(self._warm)))
        self._warm = solution if solution.solved else None
        velocity, failure = checked(solution, bounds)
        names = tuple(joint for robot in self._team.robots for joint in robot.joints)
        return HqpResult(velocity, solution.slacks, bounds, failure, problem, solution, names)


def solve_hqp(
    configuration: Configuration, stack: Stack, dt: float, *, solver: str = DEFAULT_SOLVER
) -> HqpResult:
    """Return the velocity that a stack asks for at a configuration, T(8) to T(15).

    Position limits are kept so that every joint can still stop in front of them, velocity limits
    are kept, and acceleration limits too where the configuration has a velocity. A level gets only
    the freedom that those above leave. pink: ``solve_ik``; mink: ``solve_ik``, both weighted.

    Args:
        configuration: ``robot.configuration(q)``.
        stack: levels of tasks; made ready at the first call, and then kept.
        dt: how long the velocity will be held [s].
        solver: a key of ``SOLVERS``.

    Raises:
        ConfigurationError: the stack does not fit the robots; the text names the task.
    """
    team = configuration.team
    key = (*map(id, team.robots), id(team.obstacles) if len(team.obstacles) else 0, dt, solver)
    ready: dict[Any, tuple[HqpController, Team]] = stack.kept.setdefault("solve_hqp", {})
    known = ready.get(key)
    if known is None:
        if len(ready) >= _MOST:
            del ready[next(iter(ready))]
        # The team is kept too: an id stands for an object only while that is there.
        known = ready[key] = HqpController(team, stack, dt, solver=solver), team
    return known[0].solve(configuration)


def references_of(
    aims: tuple[Aim, ...], configuration: Configuration, ahead: float = 0.0
) -> References:
    """Return the targets of tasks at a configuration's time as references.

    Args:
        aims: tasks with targets.
        configuration: where frames and bases are: the references of those without a target.
        ahead: how much later the velocities of trajectories are taken [s].
    """
    team, time = configuration.team, configuration.time
    base: dict[int, Any] = dict(enumerate(team.base_poses(configuration.q)))
    frames: dict[Any, Any] = {}
    postures: dict[Any, Any] = {}
    rates: tuple[dict[Any, Any], ...] = ({}, {}, {})
    for aim in aims:
        goal = aim.spec.goal
        if goal is None:
            continue
        value, rate = _sampled(goal, time, ahead, configuration, aim)
        key: Any = (aim.robot, aim.reference) if aim.frame else aim.robot
        kind = 0 if aim.frame else 1 if isinstance(aim.task, Posture) else 2
        (frames, postures, base)[kind][key] = value
        if rate is not None:
            rates[kind][key] = rate
    motion = Motion(rates[0], rates[2], frames, postures, rates[1])
    return References(configuration.kinematics.tools, tuple(base.values()), 0, motion)


def _sampled(
    goal: Any, time: float, ahead: float, configuration: Configuration, aim: Aim
) -> tuple[Pose | Vector, Vector | None]:
    """Return a target's value and velocity at a time; of a twist, from where the frame is."""
    if isinstance(goal, Twist):
        return configuration.kinematics.frame(aim.robot, aim.frame)[0], goal.value
    if hasattr(goal, "rate"):
        moving: Trajectory[Any] = goal
        return moving.at(time), moving.rate(time + ahead)
    return goal, None
