"""The control effort J_eff, H(10): quadratic in the inputs, its Hessian never changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.double_integrator import Horizon
from lexstack.mpc.options import EffortConfig
from lexstack.types import Matrix, Vector


class Effort:
    """J_eff = (|v|_S^2 + |u|_R^2 + |Delta u|_W^2) / 2 over the horizon.

    Attributes:
        hessian: for every joint one matrix, shape (N, N, n).
        velocity: S, shape (n,).
        input: R, shape (n,).
        change: W, shape (n,).
    """

    def __init__(self, config: EffortConfig, horizon: Horizon, joints: int, base: int = 3) -> None:
        """Condense the weights for a robot of which the first ``base`` joints are its base's."""
        self._horizon = horizon
        self.velocity = _weights(config.base_velocity, config.arm_velocity, joints, base)
        self.input = _weights(config.base_input, config.arm_input, joints, base)
        self.change = _weights(config.base_change, config.arm_change, joints, base)
        velocities, changes = horizon.to_velocity, horizon.change
        self.hessian: NDArray[np.float64] = (
            (velocities.T @ velocities)[:, :, None] * self.velocity
            + np.eye(horizon.stages)[:, :, None] * self.input
            + (changes.T @ changes)[:, :, None] * self.change
        )

    def value(self, v: Matrix, u: Matrix, previous: Vector) -> float:
        """Return J_eff of v (states 1 to N), u, both (N, n), and the input before, (n,)."""
        changes = self._changes(u, previous)
        total = (
            np.vdot(v * self.velocity, v)
            + np.vdot(u * self.input, u)
            + np.vdot(changes * self.change, changes)
        )
        return 0.5 * float(total)

    def gradient(self, v: Matrix, u: Matrix, previous: Vector) -> Matrix:
        """Return its gradient in the inputs, shape (N, n)."""
        changes = self._changes(u, previous) * self.change
        return np.asarray(
            self._horizon.to_velocity.T @ (v * self.velocity)
            + u * self.input
            + self._horizon.change.T @ changes
        )

    def _changes(self, u: Matrix, previous: Vector) -> Matrix:
        """Return u_k - u_{k-1}, with u_{-1} the input in force before, shape (N, n)."""
        changes = np.empty_like(u)
        changes[0] = u[0] - previous
        np.subtract(u[1:], u[:-1], out=changes[1:])
        return changes


def _weights(base: float, arm: float, joints: int, first: int) -> Vector:
    """Return one weight per joint, those of the base first, shape (n,)."""
    return np.concatenate((np.full(first, base), np.full(joints - first, arm)))
