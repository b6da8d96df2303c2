"""The measured and commanded state of all robots, as one value per tick."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from lexstack.types import Vector


class PlantStatus(IntEnum):
    """What a plant did in its last tick: ``status`` of ``PlantState``."""

    FOLLOWING = 0  # executed the command of the tick
    HOLDING = 1  # no command came: kept the one before
    BRAKING = 2  # no command for the watchdog's time: slows all joints down within their limits
    PAUSED = 3  # simulated time stands still


@dataclass(frozen=True, slots=True)
class RobotState:
    """All robots at one tick, stacked in the configured order; arrays are not to be written.

    Per robot: base x [m], y [m], yaw [rad] in the world frame, then the arm joints [rad].

    Attributes:
        tick: number of the control period, counted by the plant.
        stamp: simulated time [s].
        q: measured positions, shape (n,).
        v: measured velocities, shape (n,), m/s and rad/s.
        q_star: Euler integral of the commands that the plant has accepted, shape (n,).
        command: the last chi that the plant has accepted, shape (n,).
    """

    tick: int
    stamp: float
    q: Vector
    v: Vector
    q_star: Vector
    command: Vector
