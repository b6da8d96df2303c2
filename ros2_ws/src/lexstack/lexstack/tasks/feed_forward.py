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
    model, part = team.robots[robot], team.slices[robot]
    jacobian, velocity = kinematics.frame(robot, frame)[1], kinematics.state.command[part]
    if model.map is not None:  # a joint that mimics turns the frame by itself
        jacobian = model.all_joints(kinematics.state.q[team.q_slices[robot]], frame)
        velocity = model.map.matrix @ velocity
    return np.asarray(twist - 0.5 * team.dt * drift(jacobian, velocity))


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
