"""Parts of the controller that count and time what they do, for experiments and benches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, TypeVar

from lexstack.control import Controller
from lexstack.hqp import HqpProblem, HqpSolver, Solution, make_solver
from lexstack.robots import Team
from lexstack.tasks import Level
from lexstack_config.parts import Parts, build_controller
from lexstack_config.resolved import ResolvedScenario

T = TypeVar("T")


@dataclass(slots=True)
class Tally:
    """What solvers have done so far.

    Attributes:
        problems: hierarchies solved.
        levels: of all of them: one quadratic program each in a cascade.
        seconds: of wall time in the solvers.
    """

    problems: int = 0
    levels: int = 0
    seconds: float = 0.0

    def count(self, problem: HqpProblem, solution: Solution) -> None:
        """Count a hierarchy that was solved."""
        self.problems += 1
        self.levels += len(problem.levels)
        self.seconds += solution.solve_time


class WatchedSolver:
    """A solver that says what it solves."""

    def __init__(self, inner: HqpSolver, say: Callable[[HqpProblem, Solution], object]) -> None:
        """Tell ``say`` of all that ``inner`` solves."""
        self.name = inner.name
        self._inner = inner
        self._say = say

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve as the solver inside does."""
        solution = self._inner.solve(problem, warm)
        self._say(problem, solution)
        return solution


def counting_controller(
    resolved: ResolvedScenario, parts: Parts | None = None
) -> tuple[Controller, Tally]:
    """Return the controller as ``build_controller`` does, and the tally of all its solvers.

    Args:
        resolved: the scenario.
        parts: what the controller is made of; default: the scenario's.
    """
    parts, tally = parts or Parts.of(resolved), Tally()

    def solver() -> WatchedSolver:
        return WatchedSolver(make_solver(resolved.scenario.solver), tally.count)

    return build_controller(resolved, parts, solver), tally


class Stopwatch:
    """Sums the wall time of the calls that go through it.

    Attributes:
        seconds: of all calls so far.
    """

    def __init__(self) -> None:
        """Start at zero."""
        self.seconds = 0.0

    def timed(self, function: Callable[..., T]) -> Callable[..., T]:
        """Return a function that does the same and is timed."""

        def call(*arguments: Any) -> T:
            begun = perf_counter()
            try:
                return function(*arguments)
            finally:
                self.seconds += perf_counter() - begun

        return call


class TimedTeam:
    """A team whose kinematics are timed; all else is the team's own."""

    def __init__(self, team: Team, watch: Stopwatch) -> None:
        """Time ``team``."""
        self._team = team
        self.kinematics = watch.timed(team.kinematics)

    def __getattr__(self, name: str) -> Any:
        """Return what the team has under this name."""
        return getattr(self._team, name)


class TimedLevel:
    """A level of a stack whose tasks are timed."""

    def __init__(self, level: Level, watch: Stopwatch) -> None:
        """Time ``level``."""
        self.tasks, self.scales = level.tasks, level.scales
        self.linearise = watch.timed(level.linearise)


def timed_parts(parts: Parts, kinematics: Stopwatch, tasks: Stopwatch) -> Parts:
    """Return parts that do the same, with kinematics and tasks timed."""
    stacks = {
        name: replace(stack, levels=tuple(TimedLevel(level, tasks) for level in stack.levels))
        for name, stack in parts.stacks.items()
    }
    return Parts(TimedTeam(parts.team, kinematics), stacks, parts.dt)
