"""Robot A's limits as T prints them: new limits at once, T(31), or boxes blended, T(34)."""

from __future__ import annotations

from typing import Literal

import numpy as np

from lexstack.limits import Bounds, JointLimits
from lexstack.transition import alpha
from lexstack.types import RobotState, Vector
from lexstack_experiments.baselines.bounds import replaced, t31, t34

Reading = Literal["T(31)", "T(34) old limits", "T(34) last box"]
"""T(31) with the new limits at once; or T(34) with one of two readings of chi_min(t - dt)."""

Repair = Literal["brake", "give way"]
"""What a joint does whose interval is empty: it brakes, or goes towards its position limits as far
as velocity and acceleration limits allow."""


class PrintedLaw:
    """A law for robot A's box that can be empty; see ``in_force.BoundsProvider``.

    Attributes:
        dt: control period [s].
        empty_ticks: those at which a box was empty.
    """

    def __init__(
        self, own: JointLimits, dt: float, duration: float, reading: Reading, repair: Repair
    ) -> None:
        """Start with the robots' own limits; ``duration`` of the blend of T(34) [s], quintic."""
        self.dt = dt
        self.empty_ticks: list[int] = []
        self._duration, self._reading, self._repair = duration, reading, repair
        self._old = self._new = own
        self._start = 0
        self._last: Bounds | None = None

    def at(
        self, state: RobotState, wanted: JointLimits, sent: Vector | None, *, jerk: bool
    ) -> tuple[JointLimits, Bounds]:
        """Return the limits that are asked for and the printed box, empty intervals repaired."""
        if wanted is not self._new:
            self._old, self._new, self._start = self._new, wanted, state.tick
        box = t31(state.q_star, wanted, self.dt, state.command)
        before = self._before(state)
        if before is not None:
            elapsed = (state.tick - self._start) * self.dt
            box = t34(before, box, alpha("quintic", elapsed, self._duration))
        if box.empty:
            self.empty_ticks.append(state.tick)
        self._last = replaced(box, self._instead(state, wanted))
        return wanted, self._last

    def _before(self, state: RobotState) -> Bounds | None:
        """Return chi_min, chi_max (t - dt) of T(34), or None where nothing is blended."""
        if self._reading == "T(31)" or self._old is self._new:
            return None
        if self._reading == "T(34) last box":
            return self._last
        return t31(state.q_star, self._old, self.dt, state.command)

    def _instead(self, state: RobotState, limits: JointLimits) -> Vector:
        """Return what a joint with an empty interval does, shape (n,)."""
        chi: Vector = np.zeros(limits.n)
        if self._repair == "give way":
            least = (limits.position_lower - state.q_star) / self.dt
            largest = (limits.position_upper - state.q_star) / self.dt
            chi = np.clip(state.command, least, largest)
            chi = np.clip(chi, -limits.velocity, limits.velocity)
        reach = limits.acceleration * self.dt
        return np.clip(chi, state.command - reach, state.command + reach)
