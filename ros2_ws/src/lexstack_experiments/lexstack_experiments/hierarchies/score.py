"""What a solver makes of many problems: failures, certified excess, time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from lexstack.hqp import HqpProblem, HqpSolver, Solution
from lexstack_experiments.hierarchies.certificate import certified_excess
from lexstack_experiments.hierarchies.random_problems import SINGULAR
from lexstack_experiments.solvers import lexicographic_oracle

STRICT_WITHIN = 1e-6
"""Excess of a solution that still counts as strict, m/s or rad/s."""

SINGULAR_WITHIN = 1e-5
"""Likewise of level 1 next to a singularity, where rounding is divided by what is almost zero."""


@dataclass(slots=True)
class Score:
    """What a solver did on the problems of one kind; more excess than ``within`` is a failure."""

    within: float = np.inf
    excess: float = 0.0
    outside: float = 0.0
    failures: int = 0
    times: list[float] = field(default_factory=list)

    def add(
        self,
        given: HqpProblem,
        solver: HqpSolver,
        singular: bool = False,
        warm: Solution | None = None,
    ) -> Solution:
        """Solve a problem and count what came of it."""
        solution = solver.solve(given, warm)
        self.count(given, solution, singular)
        return solution

    def count(self, given: HqpProblem, solution: Solution, singular: bool = False) -> None:
        """Count a solution; next to a singularity the excess is that of level 1."""
        self.times.append(solution.solve_time)
        chi = solution.chi
        if not (solution.solved and np.isfinite(chi).all()):
            self.failures += 1
            return
        lower, upper = given.bounds.lower, given.bounds.upper
        self.outside = max(self.outside, float(np.max([lower - chi, chi - upper])))
        if singular:
            # The certificate takes the objective as linear over the box, which is far from true
            # where a level hardly feels a direction: here level 1 is solved by bounded least
            # squares. The levels below feel its rounding, divided by what is almost zero.
            (least,) = lexicographic_oracle(HqpProblem(given.levels[:1], given.bounds))
            found = [float(solution.slacks[0]) - least.optimum]
        else:
            found = certified_excess(given, np.minimum(np.maximum(chi, lower), upper))
        within = max(self.within, SINGULAR_WITHIN) if singular else self.within
        self.failures += max(found) > within
        self.excess = max(self.excess, *found)


def score(
    solver: HqpSolver, given: Iterable[tuple[str, HqpProblem]], within: float = np.inf
) -> dict[str, Score]:
    """Return a solver's score by kind of problem; an excess above ``within`` is a failure."""
    scores: dict[str, Score] = {}
    for kind, whole in given:
        scores.setdefault(kind, Score(within)).add(whole, solver, kind == SINGULAR)
    return scores
