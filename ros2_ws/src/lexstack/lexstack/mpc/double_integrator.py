"""The double integrator over the horizon, condensed: linear in the inputs, H(4) with G = I.

The base velocity is in the world frame, so q' = v and v' = u hold exactly, joint by joint. With an
input that is constant over each stage,

    v_k = v_0 + dt sum_{j<k} u_j        q_k = q_0 + k dt v_0 + dt^2 sum_{j<k} (k - j - 1/2) u_j

An input adds u_j dt^2 / 2 to q in its own stage, and its velocity u_j dt moves q by u_j dt^2 in
each of the k - j - 1 stages after that: together (k - j - 1/2) dt^2 u_j.

The same two matrices hold for every joint; they and their products depend on N and dt alone. So a
cost with the second derivative B_k by q_k has in the inputs of stages i and j, with C the matrix of
the positions, the second derivative

    H_ij = sum_k C_ki C_kj B_k,

one product of a matrix that is made once, (N N, N), with the B_k of an iterate, (N, n n).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lexstack.types import Matrix, Vector


class Horizon:
    """N stages of length dt, and the matrices that lead from inputs to states.

    Attributes:
        stages: N.
        step: dt [s].
        times: of the states 0 to N, from now, shape (N + 1,), s.
        to_position: C, q_k of the inputs, k = 1 ... N, shape (N, N).
        to_velocity: D, v_k of the inputs, shape (N, N).
        position_products: C_ki C_kj, shape (N N, N): a column for each stage k.
        velocity_products: D_ki D_kj, likewise.
        change: u to its differences, the first one from the input before, shape (N, N).
    """

    def __init__(self, stages: int, step: float) -> None:
        """Make the matrices once."""
        self.stages = stages
        self.step = step
        self.times: Vector = step * np.arange(stages + 1, dtype=np.float64)
        # Row k - 1 is for the state k, which the inputs 0 to k - 1 have moved: the lower triangle.
        past: Matrix = np.tri(stages)
        index: Vector = np.arange(stages, dtype=np.float64)
        self.to_velocity: Matrix = step * past
        # k - j - 1/2 with k - 1 for the row: from the middle of stage j to the state k, in stages.
        ages: Matrix = index[:, None] - index + 0.5
        self.to_position: Matrix = np.multiply(step * step, past * ages)
        self.position_products: Matrix = _products(self.to_position)
        self.velocity_products: Matrix = _products(self.to_velocity)
        self.change: Matrix = np.eye(stages) - np.eye(stages, k=-1)

    def roll_out(self, q: Vector, v: Vector, u: Matrix) -> tuple[Matrix, Matrix]:
        """Return q and v at the states 0 to N, shapes (N + 1, n), for inputs of shape (N, n)."""
        positions = q + self.times[:, None] * v
        positions[1:] += self.to_position @ u
        velocities = np.empty_like(positions)
        velocities[0] = v
        velocities[1:] = v + self.to_velocity @ u
        return positions, velocities

    def braking(self, v: Vector, acceleration: Vector) -> Matrix:
        """Return the inputs that stop every joint as fast as its limit allows, shape (N, n)."""
        # |v| falls by a dt in each stage, and in the last one by what is left: no joint goes back.
        reach = np.arange(self.stages + 1)[:, None] * acceleration * self.step
        speeds = np.maximum(np.abs(v) - reach, 0.0)
        return np.asarray(np.sign(v) * np.diff(speeds, axis=0) / self.step)

    def sensitivity(self, _q: Vector, _v: Vector, _u: Matrix) -> Sensitivity:
        """Return how the positions at the states follow the inputs: here the same everywhere."""
        return LinearSensitivity(self)


class Sensitivity(Protocol):
    """S_k = dq_k/du at one iterate: derivatives by the inputs of what is given by positions."""

    def gradient(self, along_q: Matrix) -> Matrix:
        """Return the gradient by the inputs (N, n) for the one by the positions, (N, n_q)."""

    def rows(self, slopes: NDArray[np.float64]) -> Matrix:
        """Return rows in the inputs (N r, N n) of rows in the positions, (N, r, n_q)."""

    def condensed(self, curved: NDArray[np.float64]) -> Matrix:
        """Return sum S_k' B_k S_k, shape (N N, n n), for curvatures B_k, (N, n_q, n_q)."""


@dataclass(frozen=True, slots=True, eq=False)
class LinearSensitivity:
    """The sensitivity of the double integrator: C_kj, times the identity."""

    horizon: Horizon

    def gradient(self, along_q: Matrix) -> Matrix:
        """Return the gradient by the inputs (N, n) for the one by the positions, (N, n)."""
        return np.asarray(self.horizon.to_position.T @ along_q)

    def rows(self, slopes: NDArray[np.float64]) -> Matrix:
        """Return rows in the inputs (N r, N n) of rows in the positions, (N, r, n)."""
        stages, count, n = slopes.shape
        rows = self.horizon.to_position[:, None, :, None] * slopes[:, :, None, :]
        return rows.reshape(stages * count, stages * n)

    def condensed(self, curved: NDArray[np.float64]) -> Matrix:
        """Return sum_k C_ki C_kj B_k, shape (N N, n n), for curvatures B_k, (N, n, n)."""
        return self.horizon.position_products @ curved.reshape(len(curved), -1)


def _products(matrix: Matrix) -> Matrix:
    """Return M_ki M_kj for every stage k, shape (N N, N)."""
    count = len(matrix)
    return np.ascontiguousarray(np.einsum("ki,kj->ijk", matrix, matrix).reshape(-1, count))
