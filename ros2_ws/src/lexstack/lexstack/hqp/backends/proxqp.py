"""The second backend: ProxQP, a proximal augmented Lagrangian method, dense."""

from __future__ import annotations

from typing import Any

import numpy as np
import proxsuite

from lexstack.hqp.cascade import NullSpaceCascade
from lexstack.hqp.hierarchy import Hierarchy, Signs
from lexstack.hqp.level_qp import LevelQp
from lexstack.types import Vector

# The second accuracy is for levels near a singularity, where ProxQP crawls; what it finds then is
# made exact by `refine` where that is possible. Nominal levels take about 10 iterations.
_ACCURACY = (1e-9, 1e-7)
_ITERATIONS = 60
_proxqp = proxsuite.proxqp


class ProxqpBackend:
    """A new ProxQP object per solve, so that it keeps nothing.

    The last bits of its results depend on where its memory lies; those of chi do not, because only
    the active set is taken.
    """

    name = "proxqp"

    def solve(self, qp: LevelQp, guess: Signs) -> Signs | str:
        """Solve with ProxQP; it starts cold, because a working set is of no use to it."""
        hessian, gradient = qp.quadratic()
        lower, upper = qp.limits()
        for accuracy in _ACCURACY:
            solver = _proxqp.dense.QP(gradient.size, 0, lower.size)
            _configure(solver.settings, accuracy)
            solver.init(hessian, gradient, None, None, qp.rows, lower, upper)
            solver.solve()
            results = solver.results
            # It stalls at its iteration limit on degenerate levels and returns what it has got.
            if results.info.status == _proxqp.QPSolverOutput.PROXQP_SOLVED:
                # A row holds if its multiplier is larger than its distance to the bound: both
                # are zero up to the accuracy for the others.
                value = qp.rows.dot(results.x)
                gap = np.where(results.z > 0.0, upper - value, value - lower)
                holds = np.abs(results.z) > np.maximum(gap, accuracy)
                sides: Signs = (np.sign(results.z) * holds).astype(np.int8)
                return sides
        return str(results.info.status.name)

    def predict_active_set(
        self,
        hierarchy: Hierarchy,
        lower: Vector,
        upper: Vector,
        guess: Signs,
    ) -> Signs | None:
        """Foresee nothing: it does not solve programs whose weights span twelve decades."""
        return None


def _configure(settings: Any, accuracy: float) -> None:
    """Set what a solve of the cascade needs."""
    settings.eps_abs = accuracy
    settings.eps_rel = 0.0
    settings.max_iter = _ITERATIONS
    settings.max_iter_in = _ITERATIONS
    settings.initial_guess = _proxqp.InitialGuess.NO_INITIAL_GUESS
    # z = 0 is feasible and H has no directions of descent without end, so both verdicts are wrong.
    settings.eps_primal_inf = settings.eps_dual_inf = 0.0


class ProxqpCascade(NullSpaceCascade):
    """The strict solver with ProxQP."""

    def __init__(self, guesses: bool = True) -> None:
        """Without ``guesses`` every level goes through ProxQP."""
        super().__init__(ProxqpBackend(), guesses)
