"""The second backend: ProxQP, a proximal augmented Lagrangian method, dense."""

from __future__ import annotations

import numpy as np
import proxsuite

from lexstack_core.hqp.cascade import NullSpaceCascade
from lexstack_core.hqp.qp import LevelQp, QpAnswer
from lexstack_core.hqp.rows import Signs

_ACCURACY = 1e-9
_ITERATIONS = 200
_proxqp = proxsuite.proxqp


class ProxqpBackend:
    """A new ProxQP object per solve: it keeps nothing, so equal input gives equal bits."""

    name = "proxqp"

    def solve(self, qp: LevelQp, guess: Signs) -> QpAnswer:
        """Solve with ProxQP; it starts cold, a working set is of no use to it."""
        hessian, gradient, rows, lower, upper = qp.assemble()
        solver = _proxqp.dense.QP(gradient.size, 0, lower.size)
        solver.settings.eps_abs = _ACCURACY
        solver.settings.eps_rel = 0.0
        solver.settings.max_iter = _ITERATIONS
        solver.settings.initial_guess = _proxqp.InitialGuess.NO_INITIAL_GUESS
        solver.init(hessian, gradient, None, None, rows, lower, upper)
        solver.solve()
        results = solver.results
        # It stalls at its iteration limit on degenerate levels and returns what it has got.
        solved = results.info.status == _proxqp.QPSolverOutput.PROXQP_SOLVED
        reason = "" if solved else results.info.status.name
        multipliers = results.z[: guess.size]
        multipliers = np.where(np.abs(multipliers) > _ACCURACY, multipliers, 0.0)
        return QpAnswer(results.x[: qp.objective.shape[1]].copy(), multipliers, reason)


def proxqp_cascade() -> NullSpaceCascade:
    """Return the strict solver with ProxQP."""
    return NullSpaceCascade(ProxqpBackend())
