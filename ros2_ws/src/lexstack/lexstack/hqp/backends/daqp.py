"""The default backend: DAQP, a dual active-set method, called directly."""

from __future__ import annotations

import math

import daqp
import numpy as np

from lexstack.hqp.cascade import NullSpaceCascade
from lexstack.hqp.hierarchy import Hierarchy, Signs
from lexstack.hqp.level_qp import LevelQp
from lexstack.hqp.weighted_guess import weighted_qp
from lexstack.types import Vector

# DAQP factors H, so a level that does not use all freedom needs a proximal term. It picks one
# optimum out of many; what it costs is removed afterwards. The second one is for levels that are
# singular but for rounding, where DAQP may fail with the first.
_SECOND_PROXIMAL = 1e-6
_ITERATIONS = 300  # for up to 100 rows and columns together, more in proportion
_FEW_ITERATIONS = 100
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

    def solve(self, qp: LevelQp, guess: Signs) -> Signs | str:
        """Solve with DAQP; ``guess`` becomes its first working set."""
        iterations = _ITERATIONS * max(1, sum(qp.rows.shape) // 50)
        sides = _solve(qp, guess, qp.proximal, iterations)
        return _solve(qp, guess, _SECOND_PROXIMAL, iterations) if isinstance(sides, str) else sides

    def predict_active_set(
        self, hierarchy: Hierarchy, lower: Vector, upper: Vector, guess: Signs
    ) -> Signs | None:
        """Return the active set of the hierarchy with weights."""
        if np.count_nonzero(~hierarchy.equal) > lower.size:
            return None  # with many slacks DAQP takes longer for this than the cascade
        qp = weighted_qp(hierarchy, lower, upper)
        sides = _solve(qp, guess, qp.proximal, _FEW_ITERATIONS)
        return None if isinstance(sides, str) else sides


def _solve(qp: LevelQp, guess: Signs, proximal: float, iterations: int) -> Signs | str:
    """Call DAQP. Its arrays must be writable: it refuses those of a frozen value."""
    hessian, gradient = qp.quadratic()
    hessian.reshape(-1)[:: gradient.size + 1] += proximal
    lower, upper = qp.limits()
    sense = np.zeros(lower.size, dtype=np.intc)
    sense[: guess.size][guess > 0] = _ACTIVE
    sense[: guess.size][guess < 0] = _ACTIVE | _LOWER
    _, _, flag, info = daqp.solve(
        hessian,
        gradient,
        qp.rows[qp.simple :],
        upper,
        lower,
        sense,
        primal_tol=1e-9,
        iter_limit=iterations,
        eps_prox=0.0,
    )
    multipliers = info["lam"]
    if flag <= 0:
        return _WORDS.get(flag, f"exit flag {flag}")
    if not math.isfinite(multipliers.dot(multipliers)):
        return "not finite"
    sides: Signs = np.sign(multipliers).astype(np.int8)
    return sides


class DaqpCascade(NullSpaceCascade):
    """The strict solver with DAQP."""

    def __init__(self, guesses: bool = True) -> None:
        """Without ``guesses`` every level goes through DAQP."""
        super().__init__(DaqpBackend(), guesses)
