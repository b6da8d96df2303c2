"""The kinematics of a base that drives along its heading and turns: G(q) of H(4), and its arcs.

    x' = v cos(yaw),  y' = v sin(yaw),  yaw' = w

x, y, yaw are the first three of a robot's q; v and w are the first two of its chi.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.types import Matrix, Vector


def by_chi(matrix: Matrix, yaw: float) -> Matrix:
    """Return what a matrix makes of chi, which it makes of the derivative of q: ``matrix @ G(q)``.

    Args:
        matrix: shape (m, n + 1).
        yaw: of the base [rad].

    Returns:
        shape (m, n).
    """
    result = np.array(matrix[:, 1:])
    result[:, 0] = math.cos(yaw) * matrix[:, 0] + math.sin(yaw) * matrix[:, 1]
    return result


def rate_matrix(n: int, yaw: float) -> Matrix:
    """Return G(q) with q' = G(q) chi, shape (n + 1, n), for a chi of length n."""
    return by_chi(np.eye(n + 1), yaw)


def arc(pose: Vector, v: float, w: float, dt: float) -> Vector:
    """Return x, y [m], yaw [rad] after a base drove at constant v and w for dt [s], exactly.

    The chord of the arc is v dt sin(h) / h long, with h = w dt / 2 half the turn, and lies in the
    direction yaw + h. That holds for every h: nothing is divided by w.

    Args:
        pose: x, y, yaw at the beginning, shape (3,).
        v: forward speed [m/s].
        w: yaw rate [rad/s].
        dt: s.
    """
    x, y, yaw = pose.tolist()
    half = 0.5 * w * dt
    chord = v * dt * (math.sin(half) / half if half else 1.0)
    along = yaw + half
    return np.array([x + chord * math.cos(along), y + chord * math.sin(along), yaw + w * dt])
