"""The bases of a team that are commanded by v and w, and simulated in x, y and yaw."""

from __future__ import annotations

import math

import numpy as np

from lexstack.robots import Team
from lexstack.types import Vector


class Driving:
    """From chi to the derivative of q and back, at a configuration: q' = G(q) chi of H(4).

    Attributes:
        straight: whether chi is the derivative of q: no base of the team is differential.
    """

    def __init__(self, team: Team) -> None:
        """Look up which entries of chi and of q are those of differential bases."""
        self._team = team
        # Of each robot: the yaw's place in q, those of its base and arm in q and in chi.
        self._yaws = [
            at.start + 2
            for robot, at in zip(team.robots, team.q_slices, strict=True)
            if robot.differential
        ]
        self.straight = not self._yaws
        pairs = [(r, q, x) for r, q, x in zip(team.robots, team.q_slices, team.slices, strict=True)]
        self._drives = [x.start for robot, _, x in pairs if robot.differential]
        # Where the entries of q are, which are those of chi but for x, y of differential bases.
        self._same = np.concatenate(
            [np.arange(q.start + 2 * robot.differential, q.stop) for robot, q, _ in pairs]
        )
        self._chi = np.concatenate(
            [np.arange(x.start + robot.differential, x.stop) for robot, _, x in pairs]
        )
        self._rates: Vector = np.zeros(team.nq)
        self._back: Vector = np.zeros(team.n)

    def rates(self, q: Vector, chi: Vector) -> Vector:
        """Return q' (nq,) at the configuration q, without any motion to the side of such a base.

        The array is used again, and is chi itself where chi is q'.
        """
        if self.straight:
            return chi
        rates = self._rates
        rates[self._same] = chi[self._chi]
        for yaw, drive in zip(self._yaws, self._drives, strict=True):
            rates[yaw - 2] = chi[drive] * math.cos(q[yaw])
            rates[yaw - 1] = chi[drive] * math.sin(q[yaw])
        return rates

    def velocities(self, q: Vector, rates: Vector) -> Vector:
        """Return chi (n,) of q' (nq,) at the configuration q: of a base its speed ahead.

        The array is used again, and is q' itself where chi is q'.
        """
        if self.straight:
            return rates
        chi = self._back
        chi[self._chi] = rates[self._same]
        for yaw, drive in zip(self._yaws, self._drives, strict=True):
            chi[drive] = math.cos(q[yaw]) * rates[yaw - 2] + math.sin(q[yaw]) * rates[yaw - 1]
        return chi
