"""Problems that a transition has solved beside the command's own, and what to do if one fails."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lexstack.hqp import HqpProblem, Solution, rejection_reason
from lexstack.limits.joint_limits import Bounds
from lexstack.types import Vector


class Auxiliary:
    """Solves them for one tick. A failed solution is not used: the last command is held."""

    def __init__(
        self, solve: Callable[[HqpProblem], Solution], command: Vector, bounds: Bounds
    ) -> None:
        """Solve with ``solve``; hold ``command`` (n,), which is in force, within its box."""
        self._solve = solve
        self._command = command
        self._bounds = bounds
        self._failures: list[str] = []

    @property
    def failures(self) -> str:
        """What failed at this tick, in one line; '' where nothing did."""
        return "; ".join(self._failures)

    def solve(self, problem: HqpProblem) -> Vector:
        """Return the optimum of a problem, shape (n,), or the command that is held."""
        solution = self._solve(problem)
        reason = rejection_reason(solution, problem.bounds)
        return self.held(f"auxiliary problem: {reason}") if reason else solution.chi

    def held(self, reason: str) -> Vector:
        """Return the command in force, clipped to its box, shape (n,), and keep the reason."""
        self._failures.append(f"{reason}: the last command is held")
        return np.clip(self._command, self._bounds.lower, self._bounds.upper)
