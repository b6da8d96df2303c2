"""The joint impedance control of T(40), for all robots at once."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import pinocchio as pin

from lexstack.robots import BASE_JOINTS, RobotModel, Team, along_axes
from lexstack.types import Vector


class TorqueLoop(Protocol):
    """What controls the actuators of a plant; ``ImpedanceLoop`` says what its methods take."""

    def reset(self, q: Vector) -> None:
        """Start at rest at q, shape (n,)."""
        ...

    def update(self, q: Vector, v: Vector, q_star: Vector, v_star: Vector) -> None:
        """Write the control of the next period; all arguments have shape (n,)."""
        ...


class ImpedanceLoop:
    """T(40) tau = K_qd (q*' - v) + K_qp (q* - q) + g on the arms, velocity servos on the bases.

    One set of vectors in the order of q serves both: a base joint has no stiffness, damping or
    gravity, and hands the reference velocity itself to its servo. The torque is limited, and so
    is its rate of change.

    Attributes:
        control: what the actuators get, shape (nq,): N m for arms, m/s and rad/s for bases; written
            in place. It is the loop's only memory, so whoever saves it saves the loop.
    """

    def __init__(self, team: Team, period: float, control: Vector) -> None:
        """Read the gains and limits of a team; ``period`` [s] is that of ``update``."""
        self.control = control
        self._stiffness = per_joint(team, 0.0, "stiffness")
        self._damping = per_joint(team, 0.0, "damping")
        self._feedforward = per_joint(team, 1.0, "damping")
        self._limit = per_joint(team, np.inf, "torque")
        self._negative_limit = -self._limit
        self._change = per_joint(team, np.inf, "torque_rate") * period
        self._gravity = _Gravity(team)
        self._wanted: Vector = np.zeros(team.nq)
        self._scratch: Vector = np.zeros(team.nq)
        self._lower: Vector = np.zeros(team.nq)
        self._upper: Vector = np.zeros(team.nq)

    def reset(self, q: Vector) -> None:
        """Start at rest at q, shape (nq,), with the torques that hold it."""
        np.clip(self._gravity(q), self._negative_limit, self._limit, out=self.control)

    def update(self, q: Vector, v: Vector, q_star: Vector, v_star: Vector) -> None:
        """Write the control of the next period; all arguments have shape (nq,).

        Args:
            q: measured positions [m, rad].
            v: measured velocities, the derivative of q [m/s, rad/s].
            q_star: desired positions.
            v_star: desired velocities.
        """
        wanted, scratch, control = self._wanted, self._scratch, self.control
        np.copyto(wanted, self._gravity(q))
        np.subtract(q_star, q, out=scratch)
        scratch *= self._stiffness
        wanted += scratch
        np.multiply(self._feedforward, v_star, out=scratch)
        wanted += scratch
        np.multiply(self._damping, v, out=scratch)
        wanted -= scratch
        # First the rate, then the limit: both hold since the torque before was within its limit.
        np.subtract(control, self._change, out=self._lower)
        np.add(control, self._change, out=self._upper)
        np.maximum(wanted, self._lower, out=wanted)
        np.minimum(wanted, self._upper, out=wanted)
        np.clip(wanted, self._negative_limit, self._limit, out=control)


class _Gravity:
    """g(q) of the nominal models: what the arms' controllers know of their load."""

    def __init__(self, team: Team) -> None:
        """Make the workspaces."""
        self._robots = [
            (
                robot,
                robot.pinocchio.createData(),
                at,
                slice(at.start + robot.arm_q.start, at.stop),
            )
            for robot, at in zip(team.robots, team.q_slices, strict=True)
        ]
        self._torque: Vector = np.zeros(team.nq)

    def __call__(self, q: Vector) -> Vector:
        """Return g(q), shape (nq,), N m and 0 on planar bases; the array is used again."""
        torque = self._torque
        for robot, data, at, arm in self._robots:
            torque[arm] = gravity(robot, data, q[at])[robot.arm_q]
        return torque


def gravity(robot: RobotModel, data: pin.Data, q: Vector) -> Vector:
    """Return g(q) along the entries of q, shape (nq,), with what mimicking joints carry."""
    full = pin.computeGeneralizedGravity(robot.pinocchio, data, robot.positions(q))
    reduced: Vector = full if robot.map is None else robot.map.matrix.T @ full
    return reduced


def per_joint(team: Team, base: str | float, arm: str) -> Vector:
    """Return one value per entry of q, shape (nq,): fields of base (or a number) and arm."""
    parts = []
    for robot in team.robots:
        config = robot.config
        if config.base is not None:
            number = not isinstance(base, str)
            values = (base,) * len(BASE_JOINTS) if number else getattr(config.base, base)
            parts.append(along_axes(values))
        parts.append(getattr(config.arm, arm))
    return np.concatenate(parts)
