"""Spheres in the robots' way, at any time: a function of simulated time alone."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import shown
from lexstack.robots.options import ObstacleConfig
from lexstack.types import Matrix, Vector


class Obstacles:
    """What the robots must not touch.

    Attributes:
        names: in the order in which they were given.
        radii: shape (k,), m.
        moving: whether any of them moves.
        resting: which of them never move, shape (k,).
    """

    def __init__(self, configs: Mapping[str, ObstacleConfig]) -> None:
        """Take them by their names."""
        self.names = tuple(configs)
        values = configs.values()
        shape = (len(configs), 3)
        self.radii: Vector = np.array([config.radius for config in values])
        self._starts: Matrix = np.reshape([config.position for config in values], shape)
        self._velocities: Matrix = np.reshape([config.velocity for config in values], shape)
        self._swings: Matrix = np.reshape([config.swing for config in values], shape)
        self._rates: Vector = np.array([2.0 * math.pi / config.period for config in values])
        self._swing = bool(self._swings.any())
        self.moving = self._swing or bool(self._velocities.any())
        self.resting = ~(self._velocities.any(axis=1) | self._swings.any(axis=1))
        for array in (
            self.radii,
            self.resting,
            self._starts,
            self._velocities,
            self._swings,
            self._rates,
        ):
            array.setflags(write=False)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.names)

    def index(self, name: str) -> int:
        """Return an obstacle's place; raises ConfigurationError listing the known."""
        if name not in self.names:
            known = ", ".join(self.names) or "none"
            raise ConfigurationError(f"unknown obstacle {shown(name)}; known: {known}")
        return self.names.index(name)

    def at(self, stamp: float) -> Matrix:
        """Return where their centers are at a simulated time [s], shape (k, 3), m, world frame."""
        if not self.moving:
            return self._starts
        centers: Matrix = self._starts + stamp * self._velocities
        if self._swing:
            share = 0.5 - 0.5 * np.cos(stamp * self._rates)
            centers += share[:, None] * self._swings
        return centers
