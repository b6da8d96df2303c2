"""What a plant measures of itself, as late, coarse and noisy as its scenario says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_config.plant import PlantConfig


@dataclass(slots=True)
class Memory:
    """What the senses remember.

    Attributes:
        random: of the noise and the slip.
        past: the last positions and velocities, oldest first from ``at`` on, shape (k, 2, n).
        at: the place of the oldest one.
        q: measured positions of this tick, shape (n,), m and rad.
        v: measured velocities of this tick, shape (n,), m/s and rad/s.
        grip: part of the commanded velocity that arrives in this tick, shape (n,).
    """

    random: np.random.Generator
    past: Vector
    at: int
    q: Vector
    v: Vector
    grip: Vector


class Senses:
    """Sensors of all robots, and the grip of their wheels.

    The torque loop reads its joints by itself; this is what the controllers are told.

    Attributes:
        perfect: whether everything is measured as it is, at once.
        slips: whether wheels slip.
    """

    def __init__(self, config: PlantConfig, team: Team, period: float) -> None:
        """Read the scenario's numbers; ``period`` [s] is that of ``see``."""
        self._config = config
        self._arms = _joints(team, [robot.arm for robot in team.robots])
        self._bases = _joints(team, [robot.base for robot in team.robots])
        self._age = round(config.latency / period)  # steps
        self.perfect = not (config.encoder_step or config.velocity_noise or self._age)
        self.slips = config.base_slip > 0.0

    def begin(self, q: Vector, seed: int) -> Memory:
        """Return the memory of a plant that has always been at rest at q, shape (n,)."""
        past = np.zeros((self._age + 1, 2, q.size))
        past[:, 0] = q
        random = np.random.default_rng(seed)
        memory = Memory(random, past, 0, q.copy(), np.zeros(q.size), np.ones(q.size))
        self.measure(memory, q, memory.v)
        return memory

    def see(self, memory: Memory, q: Vector, v: Vector) -> None:
        """Keep the present positions and velocities, shape (n,) each, for later."""
        memory.past[memory.at] = q, v
        memory.at = (memory.at + 1) % len(memory.past)

    def measure(self, memory: Memory, q: Vector, v: Vector) -> None:
        """Write what is measured at the end of a tick, and draw the grip of the next one.

        Args:
            memory: whose ``q``, ``v`` and ``grip`` are written.
            q: true positions, shape (n,).
            v: true velocities, shape (n,).
        """
        step, noise, slip = (
            self._config.encoder_step,
            self._config.velocity_noise,
            self._config.base_slip,
        )
        memory.q[:], memory.v[:] = memory.past[memory.at] if self._age else (q, v)
        if step:
            memory.q[self._arms] = step * np.round(memory.q[self._arms] / step)
        if noise:
            memory.v += noise * memory.random.standard_normal(memory.v.size)
        if slip:
            lost = slip * memory.random.uniform(0.0, 2.0, self._bases.size)
            memory.grip[self._bases] = 1.0 - lost


def _joints(team: Team, parts: Sequence[slice]) -> Vector:
    """Return the places in chi of a part of every robot."""
    places = np.arange(team.n)
    return np.concatenate(
        [places[whole][part] for whole, part in zip(team.slices, parts, strict=True)]
    )
