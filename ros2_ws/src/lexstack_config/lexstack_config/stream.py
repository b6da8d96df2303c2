"""The schema of streams of targets in a scenario: what a joystick or a camera would send."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lexstack.errors import ConfigurationError
from lexstack.options import at_most, finite, not_negative, positive
from lexstack.robots import Vector3

_FASTEST = 1000.0  # Hz


@dataclass(frozen=True, slots=True)
class StreamConfig:
    """Targets at a steady rate: where the robot starts, plus swing sin(2 pi frequency t)."""

    robot: str
    end: float  # s, simulated
    swing: Vector3  # m, along x, y, z of the world; of a base: m, m, rad
    frequency: float  # Hz, of the swing
    target: Literal["ee", "base"] = "ee"
    rate: float = 60.0  # Hz, messages per simulated second
    start: float = 0.0  # s, simulated
    ahead: float = 0.0  # s, how far its stamps are ahead; 0: without a stamp, which means now

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        positive(where, rate=self.rate, frequency=self.frequency)
        at_most(where, _FASTEST, rate=self.rate)
        not_negative(where, start=self.start, ahead=self.ahead)
        finite(where, swing=self.swing, end=self.end)
        if self.end <= self.start:
            raise ConfigurationError(f"{where}: end: must be after start, got {self.end}")
