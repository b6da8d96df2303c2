"""The speed at which a limit of a frame may be approached: what inequalities of frames share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import Range
from lexstack.robots import Team
from lexstack.tasks.collision_avoidance import damped_speed
from lexstack.types import Vector

_SHARE = 0.5  # of the joints' acceleration; the other half is for how rows and limits turn


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """The law w(r) of ``collision_avoidance`` for one row of one robot.

    Attributes:
        able: part of the joints' accelerations that may be used, shape (n_robot,).
        gain: g [1/s].
        deceleration: a, per s^2 of the unit of the room.
        dt: control period [s].
    """

    able: Vector
    gain: float
    deceleration: float
    dt: float

    @classmethod
    def of(cls, team: Team, robot: int, gain: float, deceleration: float) -> Approach:
        """Return that of a robot."""
        able = _SHARE * team.limits.acceleration[team.slices[robot]]
        return cls(able, gain, deceleration, team.dt)

    def speed(self, room: float, row: Vector) -> Vector:
        """Return w(r), shape (1,), of a row over the robot's joints, shape (n_robot,)."""
        able = np.array([min(float(np.abs(row) @ self.able), self.deceleration)])
        return damped_speed(np.array([room]), able, self.gain, self.dt)


def check_approach(where: str, gain: float, deceleration: float, dt: float) -> None:
    """Raise ConfigurationError for a gain or deceleration out of range."""
    for key, value in (("gain", gain), ("deceleration", deceleration)):
        Range(0.0, open=True).check(value, f"{where}: {key}")
    if gain * dt > 1.0:
        limit = f"must be <= {1.0 / dt:g} 1/s, one over the control period"
        raise ConfigurationError(f"{where}: gain: {limit}, got {gain}")
