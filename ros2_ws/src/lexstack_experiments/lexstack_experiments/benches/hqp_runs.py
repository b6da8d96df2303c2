"""What solvers do on a sequence of problems: judged by the certificate, timed in turns."""

from __future__ import annotations

from dataclasses import dataclass
from time import thread_time
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lexstack.hqp import Hierarchy, HqpProblem, HqpSolver, Solution
from lexstack_experiments.benches.child import Child, in_turns
from lexstack_experiments.hierarchies.peers import answered
from lexstack_experiments.hierarchies.recorded import Sequence
from lexstack_experiments.hierarchies.score import STRICT_WITHIN, Score
from lexstack_experiments.hierarchies.weighted import FALL, Weighted
from lexstack_experiments.measuring import no_collection, silent

_US = 1e6


class Contestant(Protocol):
    """Somebody who solves the problems of a sequence, in their order."""

    name: str
    solves: str
    strict: bool

    def take(self, problems: tuple[HqpProblem, ...]) -> bool:
        """Take the problems of a sequence; return whether it can solve such problems."""

    def solutions(self) -> list[Solution]:
        """Return the solution of every problem; this warms up, too."""

    def times(self) -> NDArray[np.float64]:
        """Return the thread's processor time of every problem [s]."""


class Local:
    """A solver of this process, warm from the problem before."""

    def __init__(self, solver: HqpSolver, name: str = "", solves: str = "") -> None:
        """Use a solver."""
        self.name, self.strict = name or solver.name, not isinstance(solver, Weighted)
        self.solves = solves or getattr(solver, "solves", "")
        self._solver = solver
        self._problems: tuple[HqpProblem, ...] = ()

    def take(self, problems: tuple[HqpProblem, ...]) -> bool:
        """Take problems; those with weights take no inequality rows."""
        self._problems = problems
        return self.strict or not has_intervals(problems)

    def solutions(self) -> list[Solution]:
        """Solve all."""
        warm, found = None, []
        for problem in self._problems:
            warm = self._solver.solve(problem, warm)
            found.append(warm)
        return found

    def times(self) -> NDArray[np.float64]:
        """Solve all, and time each."""
        times, warm = np.empty(len(self._problems)), None
        for k, problem in enumerate(self._problems):
            begun = thread_time()
            warm = self._solver.solve(problem, warm)
            times[k] = thread_time() - begun
        return times


class Placo:
    """placo's QP with the levels as soft constraints, in a Python that has it."""

    name, strict = "placo, weighted", False
    solves = f"one QP, costs 1, 1/{FALL:g}, 1/{FALL * FALL:g}, ... by level"

    def __init__(self, child: Child) -> None:
        """Ask a worker ``hqp_placo``."""
        self._child = child
        self._problems: tuple[HqpProblem, ...] = ()

    def take(self, problems: tuple[HqpProblem, ...]) -> bool:
        """Send problems; ours of inequality rows are not put to those with weights."""
        self._problems = problems
        if has_intervals(problems):
            return False
        self._child.ask("load", problems=[_listed(problem) for problem in problems])
        return True

    def solutions(self) -> list[Solution]:
        """Return what the worker finds."""
        found = self._child.ask("solve")
        return [
            _solution(problem, np.array(chi), reason)
            for problem, chi, reason in zip(
                self._problems, found["chi"], found["reasons"], strict=True
            )
        ]

    def times(self) -> NDArray[np.float64]:
        """Return the worker's times."""
        return np.array(self._child.ask("solve")["times"])


def _listed(problem: HqpProblem) -> dict[str, object]:
    """Return a problem of equality rows as JSON holds it."""
    hierarchy = Hierarchy(problem.levels, problem.bounds.lower.size)
    levels = [(level.matrix, level.lower) for level in hierarchy.levels]
    return {"levels": levels, "lower": problem.bounds.lower, "upper": problem.bounds.upper}


def _solution(problem: HqpProblem, chi: NDArray[np.float64], reason: str) -> Solution:
    """Return a worker's chi as a solution."""
    hierarchy = Hierarchy(problem.levels, chi.size)
    return answered(chi, hierarchy.slacks(hierarchy.residual(chi)), reason, 0.0)


@dataclass(frozen=True, slots=True)
class Run:
    """What a solver did on a sequence.

    Attributes:
        failures: no answer, or one that is not strict.
        excess: largest certified one.
        outside: how far chi left the bounds.
        times: shape (passes, problems) [us].
    """

    failures: int
    excess: float
    outside: float
    times: NDArray[np.float64]

    @property
    def p50(self) -> float:
        """Median over all passes [us]."""
        return float(np.median(self.times))

    @property
    def p99(self) -> float:
        """99th percentile over all passes [us]."""
        return float(np.percentile(self.times, 99.0))

    @property
    def strict(self) -> bool:
        """Whether all problems were solved as a hierarchy demands."""
        return self.failures == 0 and self.excess <= STRICT_WITHIN


def has_intervals(problems: tuple[HqpProblem, ...]) -> bool:
    """Return whether a sequence has inequality rows."""
    tasks = [task for level in problems[0].levels for task in level]
    return any((task.lower != task.upper).any() for task in tasks)


def measured(sequence: Sequence, contestants: list[Contestant], passes: int) -> dict[str, Run]:
    """Return what everybody does on a sequence; what libraries print does not reach the terminal.

    The passes of the contestants take turns.
    """
    with silent():
        able = [one for one in contestants if one.take(sequence.problems)]
        scores = {one.name: _judged(sequence, one) for one in able}
        with no_collection():
            times = in_turns(passes, {one.name: one.times for one in able})
    return {
        name: Run(score.failures, score.excess, score.outside, _US * times[name])
        for name, score in scores.items()
    }


def _judged(sequence: Sequence, contestant: Contestant) -> Score:
    """Return failures, largest excess and largest way out of the bounds."""
    found = Score(STRICT_WITHIN)
    for problem, solution in zip(sequence.problems, contestant.solutions(), strict=True):
        found.count(problem, solution)
    return found
