"""A differential base over the horizon: H(4) with its G(q), rolled out with exact derivatives.

chi = (v, w, arm), q = (x, y, yaw, arm). The velocities stay linear in the inputs, and so do yaw and
the arm; x and y are integrals. With an input that is constant over each stage,

    x_k = x_0 + sum_{i<k} int_0^dt v_i(s) cos(yaw_i(s)) ds,    y_k likewise with the sine,
    v_i(s) = v_i + s a_i,    yaw_i(s) = yaw_i + s w_i + s^2 b_i / 2,    (a_i, b_i) the inputs.

That integral is one of Fresnel; here it is Gauss and Legendre's sum over M = 5 nodes in each stage,
whose error is below 4e-13 of the way of a stage in which the base turns by 1 rad: a stage without
inputs ends where the arc of ``RobotModel.integrate`` does. v and yaw at the nodes are linear in the
inputs, V = V_0 + A a and Y = Y_0 + B b with constant matrices, so

    dx_k/da_j = sum w_m cos(Y_m) A_mj          dx_k/db_j = - sum w_m V_m sin(Y_m) B_mj
    dy_k/da_j = sum w_m sin(Y_m) A_mj          dy_k/db_j =   sum w_m V_m cos(Y_m) B_mj

over all nodes m before the state k are the derivatives of the very sum that is rolled out, to
rounding. With them S_k = dq_k/du; a cost with gradient g_k and curvature B_k by q_k has in the
inputs the gradient sum S_k' g_k and the Gauss-Newton Hessian sum S_k' B_k S_k.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.double_integrator import Horizon
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS  # on [0, 1]
QUADRATURE: Matrix = np.ascontiguousarray(np.stack((_NODES, _WEIGHTS), axis=1))
"""Nodes and weights of a stage, shape (5, 2)."""


def driven(q: Vector, v: Vector, u: Vector, duration: float) -> Vector:
    """Return where a robot on a differential base is after a constant input.

    Args:
        q: x [m], y [m], yaw [rad], arm; shape (n + 1,).
        v: v [m/s], w [rad/s], arm; shape (n,).
        u: their derivatives, shape (n,).
        duration: s.
    """
    s = duration * _NODES
    speed, yaw = v[0] + s * u[0], q[2] + s * (v[1] + 0.5 * s * u[1])
    weighted = duration * _WEIGHTS * speed
    result = np.empty_like(q)
    result[0] = q[0] + weighted @ np.cos(yaw)
    result[1] = q[1] + weighted @ np.sin(yaw)
    result[2:] = q[2:] + duration * v[1:] + 0.5 * duration * duration * u[1:]
    return result


class UnicycleHorizon(Horizon):
    """The horizon of a robot on a differential base; all but x and y is that of ``Horizon``."""

    def __init__(self, stages: int, step: float) -> None:
        """Make the matrices once."""
        super().__init__(stages, step)
        self._at = (self.times[:-1, None] + step * _NODES).ravel()
        before = np.zeros((2, 1, stages))
        velocity = np.concatenate((before[0], self.to_velocity[:-1]))[:, None]
        position = np.concatenate((before[1], self.to_position[:-1]))[:, None]
        own, s = np.eye(stages)[:, None], step * _NODES[:, None]
        self._to_speed: Matrix = (velocity + s * own).reshape(-1, stages)
        self._to_yaw: Matrix = (position + s * velocity + 0.5 * s * s * own).reshape(-1, stages)
        self._weights: Vector = np.tile(step * _WEIGHTS, stages)

    def roll_out(self, q: Vector, v: Vector, u: Matrix) -> tuple[Matrix, Matrix]:
        """Return q (N + 1, n + 1) and v (N + 1, n) at the states 0 to N, for inputs (N, n)."""
        linear, velocities = super().roll_out(q[1:], v, u)
        positions = np.empty((len(linear), len(q)))
        positions[:, 2:] = linear[:, 1:]
        speed, yaw = self._nodes(q, v, u)
        weighted = self._weights * speed
        for axis, direction in enumerate((np.cos(yaw), np.sin(yaw))):
            ways = (weighted * direction).reshape(self.stages, -1).sum(axis=1)
            positions[0, axis] = q[axis]
            positions[1:, axis] = q[axis] + np.cumsum(ways)
        return positions, velocities

    def sensitivity(self, q: Vector, v: Vector, u: Matrix) -> UnicycleSensitivity:
        """Return how the positions at the states follow the inputs u from the state q, v."""
        speed, yaw = self._nodes(q, v, u)
        cos, sin = self._weights * np.cos(yaw), self._weights * np.sin(yaw)
        stages = self.stages
        drive = np.empty((stages, 2, stages, 2))
        for axis, (along, across) in enumerate(((cos, -speed * sin), (sin, speed * cos))):
            for place, slopes in enumerate(
                (along[:, None] * self._to_speed, across[:, None] * self._to_yaw)
            ):
                of_stage = slopes.reshape(stages, -1, stages).sum(axis=1)
                drive[:, axis, :, place] = np.cumsum(of_stage, axis=0)
        return UnicycleSensitivity(self, drive)

    def _nodes(self, q: Vector, v: Vector, u: Matrix) -> tuple[Vector, Vector]:
        """Return speed [m/s] and yaw [rad] at the nodes of all stages, shape (N M,)."""
        speed = v[0] + self._to_speed @ u[:, 0]
        return speed, q[2] + self._at * v[1] + self._to_yaw @ u[:, 1]


@dataclass(frozen=True, slots=True, eq=False)
class UnicycleSensitivity:
    """S_k = dq_k/du at one iterate; as ``LinearSensitivity``, with q of length n + 1.

    Attributes:
        horizon: how yaw and arm follow the inputs.
        drive: d(x_k, y_k)/d(u_v, u_w) of the inputs j, shape (N, 2, N, 2).
    """

    horizon: Horizon
    drive: Array

    def gradient(self, along_q: Matrix) -> Matrix:
        """Return the gradient by the inputs (N, n) for the one by the positions, (N, n + 1)."""
        result = np.zeros((len(along_q), along_q.shape[1] - 1))
        result[:, 1:] = self.horizon.to_position.T @ along_q[:, 2:]
        result[:, :2] += np.einsum("kcjd,kc->jd", self.drive, along_q[:, :2])
        return result

    def rows(self, slopes: Array) -> Matrix:
        """Return rows in the inputs (N r, N n) of rows in the positions, (N, r, n + 1)."""
        stages, count, coordinates = slopes.shape
        rows = np.zeros((stages, count, stages, coordinates - 1))
        rows[..., 1:] = self.horizon.to_position[:, None, :, None] * slopes[:, :, None, 2:]
        rows[..., :2] += np.einsum("krc,kcjd->krjd", slopes[:, :, :2], self.drive)
        return rows.reshape(stages * count, -1)

    def condensed(self, curved: Array) -> Matrix:
        """Return sum S_k' B_k S_k, shape (N N, n n), for curvatures B_k, (N, n + 1, n + 1)."""
        stages, n = len(curved), curved.shape[1] - 1
        horizon, drive = self.horizon, self.drive
        full = np.zeros((stages, stages, n, n))
        rest = np.ascontiguousarray(curved[:, 2:, 2:]).reshape(stages, -1)
        full[:, :, 1:, 1:] = (horizon.position_products @ rest).reshape(
            stages, stages, n - 1, n - 1
        )
        # x and y with all that is linear: sum_k (dx_k/du_i)' B_k[x, .] C_kj, and its transpose.
        ways = drive.reshape(stages, 2, 2 * stages)
        mixed = (ways.transpose(0, 2, 1) @ curved[:, :2, 2:]).reshape(stages, stages, 2, -1)
        cross = np.tensordot(mixed, horizon.to_position, axes=(0, 0)).transpose(0, 3, 1, 2)
        full[:, :, :2, 1:] += cross
        full[:, :, 1:, :2] += cross.transpose(1, 0, 3, 2)
        # x and y with each other.
        pushed = curved[:, :2, :2] @ ways
        both = ways.reshape(2 * stages, -1).T @ pushed.reshape(2 * stages, -1)
        full[:, :, :2, :2] += both.reshape(stages, 2, stages, 2).transpose(0, 2, 1, 3)
        return full.reshape(stages * stages, n * n)
