"""What the plant remembers and tells of itself, beside the state of the robots."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.errors import LexstackError
from lexstack.types import PlantStatus as Status
from lexstack.types import Vector
from lexstack_sim.sensors import SensorState
from lexstack_sim.wrench import Wrench

__all__ = ["Counters", "PlantError", "PlantState", "Snapshot", "Status"]


class PlantError(LexstackError):
    """The simulation itself went wrong."""


@dataclass(slots=True)
class Counters:
    """Ticks since the last reset in which something was not as it should be."""

    missing: int = 0  # no command came
    over_velocity: int = 0  # the command exceeded a velocity limit
    over_acceleration: int = 0  # the command changed by more than an acceleration limit allows
    clamped: int = 0  # q* had run away from q and was pulled back
    contact: int = 0  # robots touched each other or an obstacle


@dataclass(slots=True)
class PlantState:
    """All that the plant remembers beside MuJoCo's own state."""

    q_star: Vector
    command: Vector
    effort: Vector
    sensors: SensorState
    tick: int = 0
    silence: int = 0  # ticks since the last command
    status: Status = Status.FOLLOWING
    contacts: int = 0  # points at which robots touch each other or an obstacle
    contact_force: float = 0.0  # N, sum of their normal forces


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A state of the plant to come back to, exactly."""

    physics: Vector
    plant_state: PlantState
    counters: Counters
    wrenches: tuple[Wrench, ...]
