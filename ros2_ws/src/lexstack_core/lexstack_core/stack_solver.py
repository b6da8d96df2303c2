"""What robot B does: it solves the new stack for the present state, T(35), T(38), T(39)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lexstack_core.bounds import Bounds, target_bounds
from lexstack_core.hqp import HqpProblem, HqpSolver, Solution
from lexstack_core.linear import Vector
from lexstack_core.model import Kinematics, Team
from lexstack_core.references import References
from lexstack_core.stack import Level, Stack
from lexstack_core.tasks import TASKS


class StackSolver:
    """Solves any of the known stacks without an acceleration box: a target, not a command."""

    def __init__(
        self, team: Team, stacks: Mapping[str, Stack], solver: HqpSolver, dt: float
    ) -> None:
        """Know the stacks by name; ``dt`` is the control period [s]."""
        self._team = team
        self._stacks = stacks
        self._solver = solver
        self._dt = dt
        self._warm: tuple[str, Solution] | None = None

    def bounds(self, stack: str, kinematics: Kinematics) -> Bounds:
        """Return the viable position and velocity bounds of a stack at q*, T(35)."""
        limits = self._stacks[stack].limits or self._team.limits
        return target_bounds(kinematics.state.q_star, limits, self._dt)

    def solve(self, stack: str, kinematics: Kinematics, references: References) -> Solution:
        """Return the optimum of a stack, warm from the tick before; chi of shape (n,)."""
        problem = HqpProblem(
            self._stacks[stack].linearise(kinematics, references), self.bounds(stack, kinematics)
        )
        warm = self._warm[1] if self._warm is not None and self._warm[0] == stack else None
        solution = self._solver.solve(problem, warm)
        self._warm = (stack, solution) if solution.solved else None
        return solution

    def chi(self, stack: str, kinematics: Kinematics, references: References) -> Vector:
        """Return the optimum of a stack, shape (n,), or zeros where it cannot be solved."""
        solution = self.solve(stack, kinematics, references)
        return solution.chi if solution.solved else np.zeros(self._team.n)

    def at_rest(self, stack: str) -> Stack:
        """Return level 1 of a stack with minimum velocity below it."""
        tasks = tuple(
            TASKS["minimum_velocity"](self._team, robot, {}, "at rest")
            for robot in range(len(self._team.robots))
        )
        levels = (self._stacks[stack].levels[0], Level(tasks, (1.0,) * len(tasks)))
        return Stack(f"{stack} at rest", levels, self._stacks[stack].limits)
