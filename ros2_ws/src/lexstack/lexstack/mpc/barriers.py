"""Relaxed log barriers: finite everywhere, twice differentiable, convex."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.options import BarrierConfig, CollisionConfig
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]


def relaxed(config: BarrierConfig | CollisionConfig, room: Array) -> float:
    """Return the sum of B(z) over all z in ``room``.

    B(z) = -mu ln z for z > zeta, else mu (((z - 2 zeta) / zeta)^2 - 1) / 2 - mu ln zeta.
    """
    mu, zeta = config.mu, config.zeta
    logs = np.log(np.maximum(room, zeta))
    below = np.minimum(room, zeta) / zeta - 2.0
    # Above zeta, below^2 is 1.
    return mu * float(0.5 * (np.square(below).sum() - room.size) - logs.sum())


def slopes(config: BarrierConfig | CollisionConfig, room: Array) -> tuple[Array, Array]:
    """Return B'(z) and B''(z), of the shape of ``room``."""
    mu, zeta = config.mu, config.zeta
    inverse = 1.0 / np.maximum(room, zeta)
    first = -mu * inverse
    first += (mu / (zeta * zeta)) * np.minimum(room - zeta, 0.0)
    return first, mu * np.square(inverse)


def relaxed_within(config: BarrierConfig | CollisionConfig, room: Array, reach: float) -> float:
    """Return the sum of all B(z) + mu (ln R + z / R - 1) with z below the reach R, else 0.

    The sum of far distances, each of which pushes a little, would stand against the tasks. This is
    convex too, and its slope fades to 0 at R. An infinite reach leaves B as it is.
    """
    if np.isinf(reach):
        return relaxed(config, room)
    near = room[room < reach]
    rest = near.size * (np.log(reach) - 1.0) + near.sum() / reach
    return relaxed(config, near) + config.mu * float(rest)


def slopes_within(
    config: BarrierConfig | CollisionConfig, room: Array, reach: float
) -> tuple[Array, Array]:
    """Return the derivatives of what ``relaxed_within`` sums, of the shape of ``room``."""
    first, second = slopes(config, room)
    if np.isinf(reach):
        return first, second
    first += config.mu / reach
    far = room >= reach
    first[far] = 0.0
    second[far] = 0.0
    return first, second


class LimitBarrier:
    """Barriers for the limits of state and input over the horizon, H(7d).

    Quantities without a limit take no part.

    Attributes:
        bounded: joints with limits of position, shape (b,).
        lower: of their positions, of all velocities, of all inputs, shape (b + 2 n,).
        upper: likewise.
    """

    def __init__(
        self,
        config: BarrierConfig,
        position: tuple[Vector, Vector],
        velocity: Vector,
        acceleration: Vector,
    ) -> None:
        """Take the limits: lower and upper positions, speeds and accelerations, shape (n,)."""
        self._config = config
        lower, upper = position
        self.bounded = np.flatnonzero(np.isfinite(lower) & np.isfinite(upper))
        self._n, self._b = lower.size, self.bounded.size
        self.lower = np.concatenate((lower[self.bounded], -velocity, -acceleration))
        self.upper = np.concatenate((upper[self.bounded], velocity, acceleration))

    def value(self, q: Matrix, v: Matrix, u: Matrix) -> float:
        """Return the sum of all barriers at q, v (states 1 to N) and u, shapes (N, n)."""
        return relaxed(self._config, self._room(q, v, u))

    def slopes(self, q: Matrix, v: Matrix, u: Matrix) -> tuple[tuple[Matrix, ...], ...]:
        """Return gradient and diagonal of the Hessian, each as parts for q, v, u, (N, n)."""
        first, second = slopes(self._config, self._room(q, v, u))
        return self._split(first[1] - first[0]), self._split(second[0] + second[1])

    def _room(self, q: Matrix, v: Matrix, u: Matrix) -> Array:
        """Return what is left to the upper, then to the lower limits, shape (2, N, b + 2 n)."""
        values = np.concatenate((q[:, self.bounded], v, u), axis=1)
        room = np.empty((2, *values.shape))
        np.subtract(self.upper, values, out=room[0])
        np.subtract(values, self.lower, out=room[1])
        return room

    def _split(self, values: Matrix) -> tuple[Matrix, ...]:
        """Return the parts of q, v and u; joints without position limits get zero."""
        b, n = self._b, self._n
        position = np.zeros((len(values), n))
        position[:, self.bounded] = values[:, :b]
        return position, values[:, b : b + n], values[:, b + n :]
