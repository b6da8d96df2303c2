"""How far a simulated plant is from its model: every number is 0 for a perfect one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from lexstack.options import Finite3, NotNegative, Positive, Range


@dataclass(frozen=True, slots=True)
class PushConfig:
    """A force on a link for a while."""

    at: NotNegative  # s, simulated
    robot: str  # its name in the scenario
    link: str  # base, tool, or a link of the arm
    force: Finite3  # N, world axes
    duration: Positive  # s


@dataclass(frozen=True, slots=True)
class PlantConfig:
    """What a real plant has and its model does not; what is random follows the scenario's seed."""

    encoder_step: NotNegative = 0.0  # rad, resolution of the arms' measured positions
    # m/s and rad/s, standard deviation of the measured velocities
    velocity_noise: NotNegative = 0.0
    # s, age of the measurements when they are sent
    latency: Annotated[NotNegative, Range(most=1.0)] = 0.0
    payload: NotNegative = 0.0  # kg, at every tool; the controllers do not know of it
    friction: NotNegative = 0.0  # N m, Coulomb friction of every arm joint
    # mean part of the bases' velocity that the wheels lose
    base_slip: Annotated[NotNegative, Range(most=0.5)] = 0.0
    pushes: tuple[PushConfig, ...] = ()  # forces from outside
