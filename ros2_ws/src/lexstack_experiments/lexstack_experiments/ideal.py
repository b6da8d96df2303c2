"""The ideal plant: it does what it is told, exactly and at once."""

from __future__ import annotations

import numpy as np

from lexstack.robots import Team
from lexstack.types import RobotState, Vector
from lexstack_config.parts import home_of
from lexstack_config.resolved import ResolvedScenario


class IdealPlant:
    """q(k+1) = q(k) + dt chi: the same interface as the MuJoCo plant."""

    def __init__(self, resolved: ResolvedScenario, team: Team) -> None:
        """Start at the scenario's home, at rest."""
        self._dt = 1.0 / resolved.scenario.rate
        self._tick = 0
        self._q = home_of(team, resolved)
        self._chi: Vector = np.zeros(team.n)

    def put(self, q: Vector, chi: Vector) -> None:
        """Put the robots at q (n,), moving at chi (n,)."""
        self._q, self._chi = q.copy(), chi.copy()

    def state(self) -> RobotState:
        """Return the present state: q* is q."""
        return RobotState(self._tick, self._tick * self._dt, self._q, self._chi, self._q, self._chi)

    def step(self, chi: Vector | None) -> RobotState:
        """Advance by one tick; without a command the last one goes on."""
        if chi is not None:
            self._chi = chi.copy()
        self._q = self._q + self._dt * self._chi
        self._tick += 1
        return self.state()
