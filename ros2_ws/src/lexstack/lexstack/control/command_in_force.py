"""What every plant does with the commands of a controller: it follows, holds and brakes.

A plant keeps the command in force and q*, the integral of the commands. Between two ticks the
command is constant. These rules are those of docs/plant.md.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from lexstack.limits import JointLimits
from lexstack.types import PlantStatus, Vector

Brake = Callable[[Vector], Vector]
"""From the command in force to the next one on the way to rest, both of shape (n,)."""

_TOLERANCE = 1e-9  # relative; a command on its limit is within it


class InForce(Protocol):
    """What a plant remembers of the commands; its vectors have shape (n,) and are written.

    Attributes:
        command: chi in force, m/s and rad/s.
        q_star: the integral of the commands, m and rad.
        silence: ticks since the last command.
        status: what the plant did in its last tick.
    """

    command: Vector
    q_star: Vector
    silence: int
    status: PlantStatus


class CommandRules:
    """Follows commands; without them it holds the last one, and brakes after the watchdog's time.

    Attributes:
        step_limit: by how much the acceleration limits let a command change in a tick, shape (n,).
    """

    def __init__(
        self,
        limits: JointLimits,
        dt: float,
        watchdog: int,
        distance: Vector,
        brake: Brake | None = None,
    ) -> None:
        """Make the rules of a plant.

        Args:
            limits: of all joints.
            dt: control period [s].
            watchdog: ticks without a command after which the plant brakes.
            distance: how far q* may be from q, shape (n,), m and rad.
            brake: default: as hard as the acceleration limits allow.
        """
        self.step_limit = limits.acceleration * dt
        self._velocity = limits.velocity
        self._watchdog = watchdog
        self._distance = distance
        self._brake = brake or self._hard

    def exceeded(
        self, memory: InForce, chi: Vector, tolerance: float = _TOLERANCE
    ) -> tuple[bool, bool]:
        """Return whether a command exceeds velocity limits, and whether acceleration limits.

        Args:
            memory: of the plant, before the command.
            chi: the command, shape (n,).
            tolerance: relative.
        """
        within = 1.0 + tolerance
        change = np.abs(chi - memory.command)
        return (
            bool((np.abs(chi) > within * self._velocity).any()),
            bool((change > within * self.step_limit).any()),
        )

    def follow(self, memory: InForce, chi: Vector) -> None:
        """Put a command in force."""
        memory.command[:] = chi
        memory.silence = 0
        memory.status = PlantStatus.FOLLOWING

    def miss(self, memory: InForce) -> None:
        """Take note that no command came in this tick."""
        memory.silence += 1
        if memory.silence <= self._watchdog:
            memory.status = PlantStatus.HOLDING
        else:
            self.brake(memory)

    def brake(self, memory: InForce) -> None:
        """Put the next command of a braking motion in force."""
        memory.status = PlantStatus.BRAKING
        memory.command[:] = self._brake(memory.command)

    def bound(self, memory: InForce, q: Vector) -> bool:
        """Pull q* back where it has run away from q (n,); return whether it had."""
        bounded = np.clip(memory.q_star, q - self._distance, q + self._distance)
        if np.array_equal(bounded, memory.q_star):
            return False
        memory.q_star[:] = bounded
        return True

    def _hard(self, command: Vector) -> Vector:
        """Return the next command of the shortest way to rest within the acceleration limits."""
        return command - np.clip(command, -self.step_limit, self.step_limit)
