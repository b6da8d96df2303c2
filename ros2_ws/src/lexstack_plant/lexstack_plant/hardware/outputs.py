"""What one robot is sent at a tick, as values: an arm's commands, and a platform's velocity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.limits import JointLimits
from lexstack.types import Vector
from lexstack_config.plant_file import ArmInterfaceConfig
from lexstack_plant.hardware.planar import turned
from lexstack_plant.hardware.spline import CommandSpline, Point


@dataclass(frozen=True, slots=True)
class RobotCommand:
    """One robot's commands of a tick; what its interface does not take is empty or None.

    Attributes:
        due: when the tick is, by the local clock [s]: trajectories begin then.
        points: of the arm's trajectory.
        values: of the arm's array: rad, rad/s or N m, by its type, shape (n,).
        twist: of the platform along its own axes, m/s, m/s, rad/s, shape (3,).
    """

    due: float
    points: tuple[Point, ...] = ()
    values: Vector | None = None
    twist: Vector | None = None


class ArmOutput:
    """From the commands of an arm to what its controller takes."""

    def __init__(
        self, config: ArmInterfaceConfig, limits: JointLimits, dt: float, hold: int
    ) -> None:
        """Make the output of an arm; ``hold`` [ticks] is how long a trajectory goes on alone."""
        self.type = config.type
        ahead = config.ahead if config.type == "joint_trajectory" else 1
        self._spline = CommandSpline(limits, dt, ahead, hold)
        self._dt = dt

    @property
    def led(self) -> Vector | None:
        """Where the arm is led now, shape (n,), rad and m; None: it is led by velocities."""
        return self._spline.led if self.type in ("joint_trajectory", "position") else None

    def in_flight(self, chi: Vector) -> Vector:
        """Return how far the commands up to chi (n,) will still move the arm, shape (n,)."""
        return self._dt * chi if self.led is None else self._spline.in_flight

    def begin(self, q: Vector, v: Vector) -> None:
        """Begin at a measured state, shape (n,) each."""
        self._spline.begin(q, v)

    def push(self, chi: Vector) -> None:
        """Take the command of a tick, shape (n,)."""
        self._spline.push(chi)

    def points(self) -> tuple[Point, ...]:
        """Return the trajectory from now on; of other types nothing."""
        return tuple(self._spline.points()) if self.type == "joint_trajectory" else ()

    def values(self, chi: Vector) -> Vector | None:
        """Return the array for the command in force, shape (n,); torques are made elsewhere."""
        if self.type == "velocity":
            return chi
        return self._spline.position if self.type == "position" else None


def differential_twist(chi: Vector) -> Vector:
    """Return the velocity of a differential base along its own axes, shape (3,).

    It is the same at every time of the tick, as the heading turns with the base: its way is an arc.

    Args:
        chi: forward speed [m/s] and yaw rate [rad/s], shape (2,).
    """
    return np.array([chi[0], 0.0, chi[1]])


def holonomic_twist(chi: Vector, yaw: float, dt: float) -> Vector:
    """Return the velocity of a platform along its own axes, shape (3,).

    Its axes turn while it drives: the twist is that of the middle of the tick.

    Args:
        chi: along the world's axes, m/s, m/s, rad/s, shape (3,).
        yaw: of the platform now [rad].
        dt: for how long the command is in force [s].
    """
    return turned(chi, -(yaw + 0.5 * dt * float(chi[2])))
