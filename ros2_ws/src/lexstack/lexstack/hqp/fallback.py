"""What happens when a solver fails: the next one is asked, and nothing goes out unchecked.

The order is stated once, in ``lexstack.hqp.make_solver``: the configured solver, then one
around another library that takes no guesses, so that the two share neither the library nor the
shortcut. If both fail, the solution says so, and the controller brakes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lexstack.compiled import kernel
from lexstack.hqp.problem import HqpProblem, HqpSolver, Solution, Status
from lexstack.limits.joint_limits import Bounds
from lexstack.types import Vector

_KERNEL = "lexstack.hqp.kernel.checks"

ROUNDING = 1e-7  # how far chi may leave the box, in its unit


class FallbackSolver:
    """Solvers in the order in which they are asked."""

    def __init__(self, first: HqpSolver, *others: HqpSolver) -> None:
        """Ask ``first``, and the others one after the other where it fails."""
        self.name = first.name
        self._first = first
        self._others = others

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Return the first solution that passes ``rejection_reason``; ``note``: those that did not.

        Where none does, it is the first solver's, failed, with the reasons of all.

        Raises:
            InputError: a task does not fit chi (a programming error, not a state of the robot).
        """
        first = self._first.solve(problem, warm)
        why = rejection_reason(first, problem.bounds)
        if not why:
            return first
        reasons = [f"{self._first.name}: {why}"]
        seconds = first.solve_time
        for solver in self._others:
            solution = solver.solve(problem)
            seconds += solution.solve_time
            why = rejection_reason(solution, problem.bounds)
            if not why:
                note = f"{'; '.join(reasons)}; solved by {solver.name}"
                return replace(solution, note=note, solve_time=seconds)
            reasons.append(f"{solver.name}: {why}")
        reason = "; ".join(reasons)
        return replace(first, status=Status.FAILED, reason=reason, solve_time=seconds)


def rejection_reason(solution: Solution, bounds: Bounds) -> str:
    """Return why a solution may not be sent, or '': failed, not finite, or out of the box."""
    return rejected(solution, bounds)[0]


def rejected(solution: Solution, bounds: Bounds) -> tuple[str, Vector | None]:
    """Return what ``rejection_reason`` does, and chi put into the box, where that was computed."""
    if not solution.solved:
        return solution.reason, None
    chi, fast = solution.chi, kernel(_KERNEL)
    lower, upper, inside = bounds.lower, bounds.upper, np.empty(chi.size)
    floats = chi.dtype is lower.dtype is upper.dtype is inside.dtype
    if fast is not None and floats and fast.clip(chi, lower, upper, ROUNDING, inside):
        return "", inside
    outside = np.maximum(lower - chi, chi - upper)
    if not outside.size or outside[outside.argmax()] <= ROUNDING:  # never so for a NaN
        return "", None
    if not np.isfinite(chi).all():
        return "the solver returned numbers that are not finite", None
    return f"the solver left the bounds by {outside.max():.3g}", None
