"""The velocity of a reference as a part of what a task asks for, T(16).

A command holds for a control period dt, in which the frame moves by

    x(t + dt) - x(t) = dt J chi + dt^2 / 2 (dJ/dt) chi + ...

The second term is no part of the rows. It would leave an error of |dJ/dt chi| dt / (2 K), 0.1 mm
and more while the robot moves in the null space; so it is taken off the velocity that is asked
for, with the command of the tick before for chi.
"""

from __future__ import annotations

import numpy as np

from lexstack.references import TOOL
from lexstack.robots import Kinematics, Team
from lexstack.types import Matrix, Vector


def feed_forward(
    twist: Vector, kinematics: Kinematics, team: Team, robot: int, frame: str = TOOL
) -> Vector:
    """Return what a frame is asked to move with, besides its correction, shape (6,).

    Args:
        twist: of the reference, in the middle of the coming period, shape (6,), world frame.
        kinematics: of this tick.
        team: the robots; it knows the control period.
        robot: the place of the frame's robot.
        frame: its name.
    """
    model, state = team.robots[robot], kinematics.state
    jacobian, chi = kinematics.frame(robot, frame)[1], state.command[team.slices[robot]]
    if model.map is None:
        bend = drift(jacobian, chi)
    else:  # a joint that mimics turns the frame by itself
        q = state.q[team.q_slices[robot]]
        rates = model.rate_matrix(q) @ chi if model.differential else chi
        bend = drift(model.all_joints(q, frame), model.map.matrix @ rates)
    if model.differential:
        bend[:3] += turning_drive(jacobian, chi)
    return np.asarray(twist - 0.5 * team.dt * bend)


def drift(jacobian: Matrix, velocity: Vector) -> Vector:
    """Return (dJ/dt) chi of a frame on a chain of joints, shape (6,), m/s^2 and rad/s^2.

    With the columns v_j, w_j of the joints in the order of the chain, and the angular velocity
    Omega_j of all before j: sum_j chi_j (2 Omega_j x v_j + chi_j w_j x v_j), sum_j chi_j Omega_j x
    w_j.
    """
    moved = jacobian * velocity
    linear, angular = moved[:3].T, moved[3:].T
    before = np.cumsum(angular, axis=0) - angular
    return np.concatenate(
        (
            np.cross(2.0 * before + angular, linear).sum(axis=0),
            np.cross(before, angular).sum(axis=0),
        )
    )


def turning_drive(jacobian: Matrix, chi: Vector) -> Vector:
    """Return what the turn of a differential base adds to ``drift``, v w (w_2 x v_1), shape (3,).

    Its heading v_1, the first column, turns with w, the second; see ``hqp.curvature``.
    """
    return np.cross(jacobian[3:, 1] * chi[1], jacobian[:3, 0] * chi[0])
