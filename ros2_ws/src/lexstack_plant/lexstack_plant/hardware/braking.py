"""To rest within acceleration and jerk limits, from any velocity and acceleration."""

from __future__ import annotations

import numpy as np

from lexstack.limits import JointLimits, approach_speed
from lexstack.types import Vector


class SmoothBrake:
    """The next command on the way to rest, with |a| <= a_max and |da| <= j dt.

    It brakes with the largest acceleration from which the jerk limit still lets it end at rest:
    with velocity in the place of a distance, and acceleration in that of a velocity, this is the
    approach to a limit in front of which one must stop.
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        """Read the limits; ``dt`` is the control period [s]."""
        self._limits = limits
        self._dt = dt
        # A jerk beyond this reaches the full acceleration in one tick from the opposite one.
        self._jerk = np.minimum(limits.jerk, 2.0 * limits.acceleration / dt)

    def __call__(self, command: Vector, change: Vector) -> Vector:
        """Return the next command, shape (n,).

        Args:
            command: in force, shape (n,).
            change: that of the command at the last tick, shape (n,).
        """
        dt, reach = self._dt, self._limits.acceleration
        before = change / dt
        wanted = -np.clip(approach_speed(command, self._jerk, dt), -reach, reach)
        # One tick must not go beyond rest.
        wanted = np.clip(wanted, -np.abs(command) / dt, np.abs(command) / dt)
        step = self._jerk * dt
        acceleration = np.clip(wanted, before - step, before + step)
        return command + np.clip(acceleration, -reach, reach) * dt
