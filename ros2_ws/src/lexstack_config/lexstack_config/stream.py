"""The schema of streams of targets in a scenario: what a joystick or a camera would send."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lexstack.errors import ConfigurationError
from lexstack.options import Finite, Finite3, NotNegative, Positive, Range

_FASTEST = 1000.0  # Hz


@dataclass(frozen=True, slots=True)
class StreamConfig:
    """Targets at a steady rate: where the robot starts, plus swing sin(2 pi frequency t)."""

    robot: str  # its name in the scenario
    end: Finite  # s, simulated
    swing: Finite3  # m, along x, y, z of the world; of a base: m, m, rad
    frequency: Positive  # Hz, of the swing
    target: Literal["ee", "base"] = "ee"  # of its tool (ee) or of its base
    rate: Annotated[Positive, Range(most=_FASTEST)] = 60.0  # Hz, messages per simulated second
    start: NotNegative = 0.0  # s, simulated
    ahead: NotNegative = 0.0  # s, how far its stamps are ahead; 0: without a stamp, which means now

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a stream that ends before it begins."""
        if self.end <= self.start:
            raise ConfigurationError(f"{where}: end: must be after start, got {self.end}")
