"""The torque loop T(40) of an arm that takes torques, run at every state that it sends."""

from __future__ import annotations

import numpy as np

from lexstack.robots import RobotModel, Team
from lexstack.types import Vector
from lexstack_sim.impedance import ImpedanceLoop, gravity

_STATES = 1e-3  # s, between two states of an arm that takes torques: for the torques' rate limit


class EffortLoop:
    """Joint impedance of one arm, with the gains of the robot's file."""

    def __init__(self, robot: RobotModel, *, holds_weight: bool) -> None:
        """Make the loop; ``holds_weight``: whether its torques carry the arm, or the robot does."""
        team = Team((robot,), _STATES)
        self._robot = robot
        self._data = robot.pinocchio.createData()
        self._holds_weight = holds_weight
        self._loop = ImpedanceLoop(team, _STATES, np.zeros(team.nq))

    def begin(self, q: Vector) -> None:
        """Begin with the torques that hold the robot at q, shape (nq,)."""
        self._loop.reset(q)

    def torques(self, q: Vector, v: Vector, q_star: Vector, v_star: Vector) -> Vector:
        """Return the arm's torques [N m], shape (n_arm,).

        Args:
            q: measured positions, shape (nq,).
            v: measured velocities, shape (n,).
            q_star: desired positions, shape (nq,).
            v_star: desired velocities, shape (n,).
        """
        if self._robot.differential:
            v, v_star = self._robot.rate_matrix(q) @ v, self._robot.rate_matrix(q_star) @ v_star
        self._loop.update(q, v, q_star, v_star)
        arm = self._robot.arm_q
        torques = self._loop.control[arm].copy()
        if not self._holds_weight:
            torques -= gravity(self._robot, self._data, q)[arm]
        return torques
