"""How far a simulated plant is from its model: every number is 0 for a perfect one."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.errors import ConfigurationError
from lexstack.options import finite, not_negative, positive
from lexstack.robots import Vector3


@dataclass(frozen=True, slots=True)
class PushConfig:
    """A force on a link for a while."""

    at: float  # s, simulated
    robot: str
    link: str  # base, tool, or a link of the arm
    force: Vector3  # N, world axes
    duration: float  # s

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        not_negative(where, at=self.at)
        positive(where, duration=self.duration)
        finite(where, force=self.force)


@dataclass(frozen=True, slots=True)
class PlantConfig:
    """What a real plant has and its model does not; what is random follows the scenario's seed."""

    encoder_step: float = 0.0  # rad, resolution of the arms' measured positions
    velocity_noise: float = 0.0  # m/s and rad/s, standard deviation of the measured velocities
    latency: float = 0.0  # s, age of the measurements when they are sent
    payload: float = 0.0  # kg, at every tool; the controllers do not know of it
    friction: float = 0.0  # N m, Coulomb friction of every arm joint
    base_slip: float = 0.0  # mean part of the bases' velocity that the wheels lose, in [0, 0.5]
    pushes: tuple[PushConfig, ...] = ()

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        not_negative(
            where,
            encoder_step=self.encoder_step,
            velocity_noise=self.velocity_noise,
            latency=self.latency,
            payload=self.payload,
            friction=self.friction,
            base_slip=self.base_slip,
        )
        if self.base_slip > 0.5:
            raise ConfigurationError(f"{where}: base_slip: at most 0.5, got {self.base_slip}")
        if self.latency > 1.0:
            raise ConfigurationError(f"{where}: latency: at most 1 s, got {self.latency}")
