"""Limits of input, velocity and position as constraints over the horizon, H(7d).

They can always be met: where the present state cannot keep a limit, it is opened as far as the
hardest braking needs. A last row per joint, q_N + kappa v_N within the position limits, with kappa
from v^2 / (2 a) <= kappa v, lets the joint still stop after the horizon; so what was feasible
stays so from solve to solve.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lexstack.limits.joint_limits import JointLimits
from lexstack.mpc.double_integrator import Horizon
from lexstack.types import Matrix, Vector

SLACK = 1e-9  # rounding of limits, in their own units


class HardLimits:
    """The rows: input, velocity, position of every stage, then the last one; all joints at once.

    Attributes:
        kappa: of the last row, shape (n,), s.
    """

    def __init__(self, limits: JointLimits, horizon: Horizon) -> None:
        """Lay the rows out once."""
        self._horizon = horizon
        self._limits = limits
        stages = horizon.stages
        self._stages = stages
        self.kappa: Vector = 0.5 * (limits.velocity / limits.acceleration + horizon.step)
        self._to_rows: Matrix = np.concatenate(
            (np.eye(stages), horizon.to_velocity, horizon.to_position)
        )
        position = (limits.position_lower, limits.position_upper)
        self._lower: Matrix = self._stack(-limits.acceleration, -limits.velocity, position[0])
        self._upper: Matrix = self._stack(limits.acceleration, limits.velocity, position[1])

    def at(self, q: Vector, v: Vector) -> HeldLimits:
        """Return the limits from a state, opened where braking needs it, shapes (n,)."""
        brake = self._horizon.braking(v, self._limits.acceleration)
        values = self.values(q, v, brake)
        return HeldLimits(
            self,
            (q, v),
            brake,
            np.minimum(self._lower, values),
            np.maximum(self._upper, values),
        )

    def values(self, q: Vector, v: Vector, u: Matrix) -> Matrix:
        """Return the value of every row for inputs u, shape (3 N + 1, n)."""
        stages = self._stages
        rows = np.empty((3 * stages + 1, u.shape[1]))
        rows[:-1] = self._to_rows @ u
        rows[stages : 2 * stages] += v
        rows[2 * stages : -1] += q + self._horizon.times[1:, None] * v
        rows[-1] = rows[-2] + self.kappa * rows[2 * stages - 1]
        return rows

    def rows(self, places: NDArray[np.intp]) -> Matrix:
        """Return the coefficients in u of rows and joints (2, r), shape (r, N n)."""
        row, joint = places
        stages, n = self._stages, self.kappa.size
        last = row == 3 * stages
        coefficients = self._to_rows[np.where(last, 3 * stages - 1, row)]
        coefficients += np.where(last, self.kappa[joint], 0.0)[:, None] * self._to_rows[-stages - 1]
        result = np.zeros((len(row), stages, n))
        result[np.arange(len(row))[:, None], np.arange(stages), joint[:, None]] = coefficients
        return result.reshape(len(row), stages * n)

    def _stack(self, acceleration: Vector, velocity: Vector, position: Vector) -> Matrix:
        """Return one side of all rows, shape (3 N + 1, n)."""
        count = self._stages
        return np.concatenate(
            [np.tile(side, (count, 1)) for side in (acceleration, velocity, position)]
            + [position[None]]
        )


class HeldLimits:
    """Hard limits from one state.

    Attributes:
        lower: of every row, shape (3 N + 1, n).
        upper: likewise.
    """

    def __init__(
        self,
        limits: HardLimits,
        state: tuple[Vector, Vector],
        brake: Matrix,
        lower: Matrix,
        upper: Matrix,
    ) -> None:
        """Made by ``HardLimits.at``."""
        self._limits = limits
        self._state = state
        self._brake = brake
        self.lower = lower
        self.upper = upper

    @property
    def kappa(self) -> Vector:
        """The factor of v_N in the last row, shape (n,), s."""
        return self._limits.kappa

    def values(self, u: Matrix) -> Matrix:
        """Return the value of every row, shape (3 N + 1, n)."""
        return self._limits.values(*self._state, u)

    def violated(self, u: Matrix) -> NDArray[np.intp]:
        """Return rows and joints of what the inputs violate, shape (2, r)."""
        values = self.values(u)
        beyond = (values > self.upper + SLACK) | (values < self.lower - SLACK)
        return np.array(np.nonzero(beyond))

    def repaired(self, u: Matrix) -> Matrix:
        """Return inputs in which every joint that would break a limit brakes instead."""
        joints = self.violated(u)[1]
        if not joints.size:
            return u
        result = u.copy()
        result[:, joints] = self._brake[:, joints]
        return result

    def rows(self, places: NDArray[np.intp]) -> Matrix:
        """Return the coefficients in u of rows and joints (2, r), shape (r, N n)."""
        return self._limits.rows(places)
