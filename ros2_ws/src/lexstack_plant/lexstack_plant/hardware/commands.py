"""The command in force of real robots: followed, held, braked, and which ones are refused."""

from __future__ import annotations

import numpy as np

from lexstack.control import CommandRules
from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_plant.hardware.braking import SmoothBrake
from lexstack_plant.hardware.memory import HardwareCounters, HardwareMemory
from lexstack_sim.impedance import per_joint


class Commands:
    """``CommandRules`` for robots that are stopped where the rules of the simulation only count.

    Attributes:
        rules: of every plant.
    """

    def __init__(
        self, team: Team, memory: HardwareMemory, watchdog: int, silence: int, accepted: float
    ) -> None:
        """Make the rules.

        Args:
            team: the robots.
            memory: of the plant, which holds the command in force.
            watchdog: ticks without a command after which the robots are braked.
            silence: ticks without a command after which they are disabled.
            accepted: relative, by which a command may exceed a limit.
        """
        self._team, self._m = team, memory
        self._silence, self._accepted = silence, accepted
        brake = SmoothBrake(team.limits, team.dt)
        distance = per_joint(team, "q_star_distance", "q_star_distance")
        self.rules = CommandRules(
            team.limits, team.dt, watchdog, distance, lambda chi: brake(chi, memory.change)
        )

    def accept(self, chi: Vector | None, counters: HardwareCounters) -> str:
        """Follow a command (n,), hold without one; return why the robots must stop, or ''."""
        m = self._m
        if chi is None:
            counters.missing += 1
            self.rules.miss(m)
            silent = m.silence > self._silence
            return f"no commands for {self._silence * self._team.dt:.2g} s" if silent else ""
        fast, sudden = self.rules.exceeded(m, chi, self._accepted)
        if fast or sudden:
            counters.refused += 1
            change = np.abs(chi - m.command) / self.rules.step_limit
            over = np.maximum(np.abs(chi) / self._team.limits.velocity, change)
            i = int(np.argmax(over))
            what = "velocity" if fast else "acceleration"
            return (
                f"the command exceeds the {what} limit of {self._team.joint_names[i]} "
                f"{over[i]:.3g} times"
            )
        self.rules.follow(m, chi)
        return ""
