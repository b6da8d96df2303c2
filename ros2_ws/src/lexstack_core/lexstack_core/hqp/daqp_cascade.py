"""The default backend: DAQP, a dual active-set method, called directly."""

from __future__ import annotations

import math

import daqp
import numpy as np

from lexstack_core.hqp.cascade import EXCHANGES, NullSpaceCascade
from lexstack_core.hqp.qp import LevelQp, QpAnswer
from lexstack_core.hqp.rows import Signs

# DAQP factors H, so a level that does not use all freedom needs a proximal term, relative to the
# squared norm of the task. It picks one optimum out of many; `refine` removes what it costs. The
# second one is for levels that are singular but for rounding, where DAQP fails with the first.
_PROXIMAL = (1e-9, 1e-6)
_SETTINGS = {"primal_tol": 1e-9, "dual_tol": 1e-12, "iter_limit": 300, "eps_prox": 0.0}
_ACTIVE, _LOWER = 1, 2
_WORDS = {
    -1: "infeasible",
    -2: "cycling",
    -3: "unbounded",
    -4: "iteration limit",
    -5: "not convex",
    -6: "overdetermined working set",
}


class DaqpBackend:
    """DAQP's one-shot call: it keeps nothing between solves, so equal input gives equal bits."""

    name = "daqp"

    def solve(self, qp: LevelQp, guess: Signs) -> QpAnswer:
        """Solve with DAQP; ``guess`` becomes its first working set."""
        hessian, gradient = qp.quadratic()
        lower, upper = qp.limits()
        sense = np.zeros(lower.size, dtype=np.intc)
        sense[: guess.size][guess > 0] = _ACTIVE
        sense[: guess.size][guess < 0] = _ACTIVE | _LOWER
        diagonal = hessian.reshape(-1)[:: gradient.size + 1]
        for proximal in _PROXIMAL:
            diagonal += proximal
            x, _, flag, info = daqp.solve(
                hessian, gradient, qp.rows, upper, lower, sense.copy(), **_SETTINGS
            )
            multipliers = info["lam"]
            if flag > 0 and math.isfinite(x.dot(x)) and math.isfinite(multipliers.dot(multipliers)):
                return QpAnswer(x, multipliers, "")
        return QpAnswer(x, multipliers, _WORDS.get(flag, f"exit flag {flag}, not finite"))


class DaqpCascade(NullSpaceCascade):
    """The strict solver with DAQP."""

    def __init__(self, exchanges: int = EXCHANGES) -> None:
        """Try ``exchanges`` guesses before DAQP is asked."""
        super().__init__(DaqpBackend(), exchanges)
