"""What the solver does: it solves the new stack for the present state, T(35), T(38), T(39)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lexstack.control.kernels import load_kernels
from lexstack.hqp import Damped, Damper, HqpProblem, HqpSolver, Solution
from lexstack.limits.joint_limits import Bounds
from lexstack.limits.viable_bounds import target_bounds
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.tasks.registry import TASKS
from lexstack.tasks.stack import AT_REST, Level, Stack
from lexstack.transition.messages import Announcement, SourceSample
from lexstack.transition.robot_group import RobotGroup
from lexstack.types import LinearTask


def share(stack: Stack, robots: int, number: int, count: int) -> Stack | None:
    """Return what one of several solvers solves of a stack; None: nothing.

    The team's robots are split evenly, in their order. A stack with a task that couples robots of
    different solvers is all the first one's.

    Args:
        stack: any.
        robots: how many the team has.
        number: which solver, from 1.
        count: of solvers.
    """
    if count == 1:
        return stack
    groups = [set(group.tolist()) for group in np.array_split(np.arange(robots), count)]
    if any(stack.coupling(group) for group in groups):
        return stack if number == 1 else None
    moved = range(robots) if stack.robots is None else stack.robots
    mine = tuple(robot for robot in moved if robot in groups[number - 1])
    return stack.of(mine) if mine else None


class StackSolver:
    """Solves any of the known stacks without an acceleration box: a target, not a command."""

    def __init__(
        self,
        team: Team,
        stacks: Mapping[str, Stack],
        solver: HqpSolver,
        dt: float,
        damper: Damper | None = None,
    ) -> None:
        """Know the stacks by name; ``dt`` is the control period [s].

        ``damper`` is for those who compare: another one than the default.
        """
        load_kernels()
        self._team = team
        self._stacks = dict(stacks)
        self._solver = solver
        self._dt = dt
        self._damper = damper or Damper(team, dt)
        self._groups: dict[tuple[int, ...], RobotGroup] = {}
        self._warm: dict[tuple[str, tuple[int, ...] | None], Solution] = {}

    def learn(self, stack: Stack) -> None:
        """Know one more stack by its name from now on, in place of one of the same name."""
        self._stacks[stack.name] = stack

    def bounds(self, stack: str | Stack, kinematics: Kinematics) -> Bounds:
        """Return the viable position and velocity bounds of a stack at q*, T(35)."""
        limits = self._known(stack).limits or self._team.limits
        place = self._team.joint_positions(kinematics.state.q_star)
        return target_bounds(place, limits, self._dt)

    def solve(self, stack: str | Stack, kinematics: Kinematics, references: References) -> Solution:
        """Return the optimum of a stack, warm from the last time; chi of shape (n,).

        Joints of robots that the stack does not move are 0.

        Args:
            stack: a known one by its name, or one that is not known by itself.
            kinematics: of this tick.
            references: of this tick.
        """
        known = self._known(stack)
        levels, bounds = known.linearise(kinematics, references), self.bounds(known, kinematics)
        group = self._group(known)
        key = (known.name, known.robots)
        last = self._warm.pop(key, None)
        limits = known.limits or self._team.limits
        given = HqpProblem(levels, bounds)
        damped = self._damper.damped(given, kinematics, limits)
        solution = self._solved(damped, group, last)
        if solution.solved:
            self._warm[key] = solution
        return solution

    def solves(self, stack: str) -> bool:
        """Return whether a known stack is solved: one that follows plans of the MPC is not."""
        return not self._stacks[stack].planned

    def answer(
        self, wanted: Announcement, kinematics: Kinematics, references: References
    ) -> SourceSample:
        """Return what a controller awaits that has announced a stack: its optimum of this tick."""
        solution = self.solve(wanted.stack, kinematics, references)
        return SourceSample(
            wanted.id,
            kinematics.state.tick,
            solution.chi,
            solution.solved and bool(np.isfinite(solution.chi).all()),
            float(solution.slacks[0]) if solution.slacks.size else None,
            revision=references.revision,
        )

    def _solved(self, damped: Damped, group: RobotGroup | None, last: Solution | None) -> Solution:
        """Return the solution over all joints; those that a stack does not move are at rest."""
        problem, warm = damped.problem, damped.warm(last)
        if group is None:
            return damped.own(self._solver.solve(problem, warm))
        if warm is not None:
            mine = group.columns
            warm = replace(warm, chi=warm.chi[mine], active=warm.active[mine])
        solution = self._solver.solve(_alone(problem.levels, problem.bounds, group), warm)
        return damped.own(_among_all(solution, group, self._team.n))

    def at_rest(self, stack: Stack) -> Stack:
        """Return level 1 of a stack with minimum velocity below it."""
        robots = range(len(self._team.robots)) if stack.robots is None else stack.robots
        tasks = tuple(
            TASKS["velocity_damping"](self._team, robot, {}, "at rest") for robot in robots
        )
        levels = (stack.levels[0], Level(tasks, (1.0,) * len(tasks)))
        return Stack(f"{stack.name}{AT_REST}", levels, stack.limits, stack.robots)

    def _known(self, stack: str | Stack) -> Stack:
        """Return a stack, by its name or as it is."""
        return self._stacks[stack] if isinstance(stack, str) else stack

    def _group(self, stack: Stack) -> RobotGroup | None:
        """Return the robots that a stack moves, None for all of them."""
        robots = stack.robots
        if robots is None or len(robots) == len(self._team.robots):
            return None
        if robots not in self._groups:
            self._groups[robots] = RobotGroup.of(self._team, robots)
        return self._groups[robots]


def _alone(
    levels: tuple[tuple[LinearTask, ...], ...], bounds: Bounds, group: RobotGroup
) -> HqpProblem:
    """Return a problem without the joints that it does not move."""
    mine = group.columns
    kept = tuple(
        tuple(LinearTask(task.name, task.matrix[:, mine], task.lower, task.upper) for task in level)
        for level in levels
    )
    return HqpProblem(kept, Bounds(bounds.lower[mine], bounds.upper[mine]))


def _among_all(solution: Solution, group: RobotGroup, n: int) -> Solution:
    """Return the solution of such a problem with the other joints at rest."""
    chi, active = np.zeros(n), np.zeros(n, dtype=np.int8)
    chi[group.columns], active[group.columns] = solution.chi, solution.active
    return replace(solution, chi=chi, active=active)
