"""Spheres in the robots' way, at any time: a function of the scenario and of the clock alone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lexstack_core.config.scenario import ObstacleConfig
from lexstack_core.linear import Matrix, Vector


class Obstacles:
    """What the robots must not touch; each goes straight at constant speed.

    Attributes:
        names: in the order of the scenario.
        radii: shape (k,), m.
        velocities: shape (k, 3), m/s, world frame.
    """

    def __init__(self, configs: Mapping[str, ObstacleConfig]) -> None:
        """Take them from a scenario."""
        self.names = tuple(configs)
        self.radii: Vector = np.array([config.radius for config in configs.values()])
        shape = (len(configs), 3)
        self._starts: Matrix = np.reshape([c.position for c in configs.values()], shape)
        self.velocities: Matrix = np.reshape([c.velocity for c in configs.values()], shape)
        for array in (self.radii, self._starts, self.velocities):
            array.setflags(write=False)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.names)

    def at(self, stamp: float) -> Matrix:
        """Return where their centers are at a simulated time [s], shape (k, 3), m, world frame."""
        return np.asarray(self._starts + stamp * self.velocities)
