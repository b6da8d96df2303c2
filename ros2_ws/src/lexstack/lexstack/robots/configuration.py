"""Robots at one configuration, as a program looks at them: poses and Jacobians by name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lexstack.errors import InputError
from lexstack.robots.kinematics import Kinematics, Pose
from lexstack.robots.team import Team
from lexstack.types import Matrix, RobotState, Vector


class FrameAt(NamedTuple):
    """A frame at one configuration.

    Attributes:
        pose: in the world.
        jacobian: shape (6, n_robot): linear, then angular velocity, axes parallel to the world.
    """

    pose: Pose
    jacobian: Matrix


class Configuration:
    """One robot or several at one configuration; ``Robot.configuration`` makes it.

    Attributes:
        team: the robots.
        kinematics: what tasks are made linear with.
        bounded: whether the velocity is known, so that accelerations can be kept within limits.
    """

    def __init__(self, team: Team, kinematics: Kinematics, *, bounded: bool = True) -> None:
        """Take kinematics that the team has worked out."""
        self.team = team
        self.kinematics = kinematics
        self.bounded = bounded

    @classmethod
    def of(cls, team: Team, q: object, velocity: object = None, time: float = 0.0) -> Configuration:
        """Return a team at a configuration.

        Args:
            team: the robots.
            q: shape (nq,), m and rad, as ``RobotModel`` has it, robot after robot.
            velocity: that was commanded last, shape (n,), m/s and rad/s; None: not known.
            time: for trajectories and obstacles that move [s].

        Raises:
            InputError: a shape is wrong, or a number is not finite.
        """
        place = _vector("q", q, team.nq)
        chi = np.zeros(team.n) if velocity is None else _vector("velocity", velocity, team.n)
        state = RobotState(0, time, place, chi, place, chi)
        return cls(team, team.kinematics(state), bounded=velocity is not None)

    @property
    def q(self) -> Vector:
        """The configuration, shape (nq,), m and rad."""
        return self.kinematics.state.q

    @property
    def velocity(self) -> Vector:
        """The velocity, shape (n,), m/s and rad/s; zero where it is not known."""
        return self.kinematics.state.command

    @property
    def time(self) -> float:
        """The time that it stands for [s]."""
        return self.kinematics.state.stamp

    def frame(self, name: str = "tool", robot: str = "") -> FrameAt:
        """Return pose and Jacobian of a frame.

        Args:
            name: a link or joint of the robot's URDF, one of its ``tools``, or ``tool``.
            robot: its name; it may be left out where there is one robot.

        Raises:
            InputError: there are several robots, and none is named.
            ModelError: the robot has no such frame.
        """
        if not robot and len(self.team.names) > 1:
            raise InputError(f"frame {name!r}: of which robot? {', '.join(self.team.names)}")
        place = self.team.index(robot) if robot else 0
        return FrameAt(*self.kinematics.frame(place, name))


def _vector(name: str, value: object, size: int) -> Vector:
    """Return finite numbers as a vector of its own; raises InputError."""
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        vector = np.full((), np.nan)
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise InputError(
            f"configuration: {name}: expected {size} finite numbers, got shape {vector.shape}"
        )
    vector.setflags(write=False)
    return vector
