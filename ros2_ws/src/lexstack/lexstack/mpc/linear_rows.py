"""The constraints of the levels above, made linear at an iterate: lower <= E d <= upper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.double_integrator import Sensitivity
from lexstack.mpc.lexicographic_constraints import LexicographicConstraint
from lexstack.mpc.stage_kinematics import StageKinematics
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LinearRows:
    """Rows by the positions of the states, of one constraint after the other.

    Attributes:
        slopes: of each constraint, by q, shape (N, r, n_q).
        summed: whether the rows of all states are one row, of each constraint.
        lower: of the step, at most 0, shape (g,).
        upper: of the step, at least 0, shape (g,).
        sensitivity: how the positions follow the inputs.
        moving: 1 where the level may use a joint, else 0, shape (n,); None: everywhere 1.
        size: N n, of a step.
    """

    slopes: tuple[Array, ...]
    summed: tuple[bool, ...]
    lower: Vector
    upper: Vector
    sensitivity: Sensitivity
    moving: Vector | None
    size: int

    @classmethod
    def of(
        cls,
        constraints: Sequence[LexicographicConstraint],
        at: StageKinematics,
        sensitivity: Sensitivity,
        moving: Vector | None,
        size: int,
    ) -> LinearRows:
        """Return the rows at an iterate.

        The zero step satisfies them. Where the iterate violates a constraint, which H(13) allows by
        up to delta, the bound is opened to 0: a QP that demanded to undo this would leave no
        descent. The violation need not shrink then, and to first order it cannot grow. Bounds that
        the iterate meets stay as they are; delta is not in them.
        """
        slopes, lower, upper = [], [np.zeros(0)], [np.zeros(0)]
        for constraint in constraints:
            error = constraint.task.error(at)
            value = constraint.value(error)
            slopes.append(constraint.slopes(at, error))
            lower.append(np.minimum(constraint.lower - value, 0.0))
            upper.append(np.maximum(constraint.upper - value, 0.0))
        return cls(
            tuple(slopes),
            tuple(constraint.summed for constraint in constraints),
            np.concatenate(lower),
            np.concatenate(upper),
            sensitivity,
            moving,
            size,
        )

    @cached_property
    def matrix(self) -> Matrix:
        """E by the inputs, shape (g, N n)."""
        if not self.slopes:
            return np.zeros((0, self.size))
        rows = [
            self.sensitivity.gradient(slopes[:, 0]).reshape(1, -1)
            if summed
            else self.sensitivity.rows(slopes)
            for slopes, summed in zip(self.slopes, self.summed, strict=True)
        ]
        matrix = rows[0] if len(rows) == 1 else np.concatenate(rows)
        stages = len(self.slopes[0])
        return matrix if self.moving is None else matrix * np.tile(self.moving, stages)
