"""What the adapter remembers of its robots between ticks, and what it counts."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from lexstack.types import PlantStatus, Vector


class Phase(Enum):
    """Whether robots are commanded."""

    DISABLED = "disabled"  # nothing is sent
    ENABLED = "enabled"  # they follow the controller
    STOPPING = "stopping"  # they are braked, and disabled when they are at rest


@dataclass(slots=True)
class HardwareCounters:
    """Ticks since the robots were enabled in which something was not as it should be."""

    missing: int = 0  # no command came
    refused: int = 0  # the command exceeded a limit
    clamped: int = 0  # q* had run away from q and was pulled back
    late: int = 0  # the tick was late by more than a period


@dataclass(slots=True)
class HardwareMemory:
    """What the adapter remembers between ticks; q and q* have shape (nq,), all others (n,)."""

    q_star: Vector
    q: Vector
    command: Vector
    change: Vector  # of the command at the last tick
    v: Vector
    in_flight: Vector  # how far commands on their way will move the robots, along chi
    slip: Vector  # what the commands lead farther than the measured velocities, of late
    tick: int = 0
    silence: int = 0
    status: PlantStatus = PlantStatus.FOLLOWING
    due: float = field(default=-np.inf)  # s by the local clock, of the last tick

    @classmethod
    def empty(cls, nq: int, n: int) -> HardwareMemory:
        """Return the memory of robots of which nothing is known: lengths of q and of chi."""
        return cls(*(np.zeros(length) for length in (nq, nq, n, n, n, n, n)))
