"""What a level must not spoil: H(11) as printed, H(11) per stage, H(12), and the tolerance H(13).

Each is a vector h of values at an iterate with bounds lower <= h <= upper:

    axis   h = e_kp, |h| <= |e*_kp|     H(12)
    stage  h = J_k   <= J*_k            H(11), state by state
    sum    h = J     <= J*              H(11)

The tolerance delta widens them in the line search and nowhere else.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.options import Constraint
from lexstack.mpc.stage_kinematics import StageKinematics
from lexstack.mpc.tracking_objectives import Task
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]
_ROUNDING = 1e-12  # in the unit of h: exceeded by no more, a bound is met, also with delta = 0


class LexicographicConstraint:
    """The lexicographic constraints of one solved level.

    Attributes:
        level: its place.
        task: what it minimised.
        lower: of h, shape (r,).
        upper: of h, shape (r,).
        tolerance: delta in the unit of h, shape (r,).
    """

    def __init__(self, level: int, task: Task, best: Matrix, kind: Constraint) -> None:
        """Take the errors e* at the optimum of the level, shape (N, s)."""
        self.level = level
        self.task = task
        self._kind = kind
        # ``best`` is what the level has reached. H(12) bounds |e| by |e*| on both sides; a cost may
        # fall as far as it can, so H(11) has no lower bound. delta is not in these bounds: it would
        # count twice, in the QP of a lower level and in its line search.
        value = self.value(best)
        self.upper: Vector = np.abs(value)
        self.tolerance = self._tolerance()
        if kind == "axis":
            self.upper[np.isinf(self.tolerance)] = np.inf  # rows that only guide
        self.lower: Vector = -self.upper if kind == "axis" else np.full(value.shape, -np.inf)

    def value(self, error: Matrix) -> Vector:
        """Return h for errors of shape (N, s), shape (r,)."""
        if self._kind == "axis":
            return error.reshape(-1)
        if self._kind == "stage":
            return self.task.stage_costs(error)
        return np.array([self.task.bound_cost(error)])

    @property
    def summed(self) -> bool:
        """Whether h is one number, the sum over all states."""
        return self._kind == "sum"

    def slopes(self, at: StageKinematics, error: Matrix) -> Array:
        """Return dh/dq: of each state the rows that it has a part in, shape (N, r, n_q)."""
        #   axis   de_kp/dq_k
        #   stage  dJ_k/dq_k = e_k' W_k de_k/dq_k, for J_k = e_k' W_k e_k / 2
        #   sum    likewise: J is the sum of the J_k
        jacobian = self.task.jacobian(at)
        if self._kind == "axis":
            return jacobian
        weighted = self.task.binding * error
        return np.asarray(weighted[:, None] @ jacobian)

    def excess(self, error: Matrix) -> tuple[float, str]:
        """Return by how much H(13) is violated at most (<= 0: not), and where in words."""
        # Here, and here alone, delta counts. It is measured from e* of the level above and not from
        # the present iterate, so it does not add up from step to step.
        value = self.value(error)
        beyond = np.maximum(value - self.upper, self.lower - value) - self.tolerance
        worst = int(np.argmax(beyond))
        return float(beyond[worst]) - _ROUNDING, self._name(worst)

    def _tolerance(self) -> Vector:
        """Return delta for each entry of h."""
        if self._kind == "axis":
            return np.broadcast_to(self.task.tolerance, self.task.weights.shape).reshape(-1)
        costs = self.task.stage_tolerance
        return costs if self._kind == "stage" else np.array([costs.sum()])

    def _name(self, entry: int) -> str:
        """Return an entry of h in words; level, state and row are counted from 1."""
        where = f"level {self.level + 1} {self.task.objective.name}"
        if self._kind == "axis":
            state, row = divmod(entry, self.task.tolerance.size)
            return f"{where}, state {state + 1}, row {row + 1}"
        return f"{where}, state {entry + 1}" if self._kind == "stage" else f"{where}, sum"
