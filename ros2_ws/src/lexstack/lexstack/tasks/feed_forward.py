"""The velocity of a reference as a part of what a task asks for, T(16).

A command holds for a control period dt, in which the frame moves by

    x(t + dt) - x(t) = dt J chi + dt^2 / 2 (dJ/dt) chi + ...

The second term is no part of the rows. It would leave an error of |dJ/dt chi| dt / (2 K), 0.1 mm
and more while the robot moves in the null space; so it is taken off the velocity that is asked
for, with the command of the tick before for chi.
"""

from __future__ import annotations

import numpy as np

from lexstack.types import Matrix, Vector


def feed_forward(
    twist: Vector, jacobian: Matrix, command: Vector, dt: float, unicycle: bool = False
) -> Vector:
    """Return what a frame is asked to move with, besides its correction, shape (6,).

    Args:
        twist: of the reference, in the middle of the coming period, shape (6,), world frame.
        jacobian: of the frame, shape (6, n_robot), LOCAL_WORLD_ALIGNED.
        command: the robot's joint velocities of the tick before, shape (n_robot,).
        dt: control period [s].
        unicycle: whether its first two columns are those of a differential base.
    """
    return np.asarray(twist - 0.5 * dt * drift(jacobian, command, unicycle))


def drift(jacobian: Matrix, velocity: Vector, unicycle: bool = False) -> Vector:
    """Return (dJ/dt) chi of a frame on a chain of joints, shape (6,), m/s^2 and rad/s^2.

    With the columns v_j, w_j of the joints in the order of the chain, and the angular velocity
    Omega_j of all before j: sum_j chi_j (2 Omega_j x v_j + chi_j w_j x v_j), sum_j chi_j Omega_j x
    w_j. Of a differential base, (v, w) in the first two places, v w_2 x v_1 is added: its heading
    turns with w, see ``hqp.curvature``.
    """
    moved = jacobian * velocity
    linear, angular = moved[:3].T, moved[3:].T
    before = np.cumsum(angular, axis=0) - angular
    result = np.concatenate(
        (
            np.cross(2.0 * before + angular, linear).sum(axis=0),
            np.cross(before, angular).sum(axis=0),
        )
    )
    if unicycle:
        result[:3] += np.cross(angular[1], linear[0])
    return result
