"""What a plant measures of itself, as late, coarse and noisy as its scenario says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_config.plant import PlantConfig


@dataclass(slots=True)
class SensorState:
    """What the sensors remember.

    Attributes:
        random: of the noise and the slip.
        past_q: the last positions, oldest first from ``at`` on, shape (k, nq).
        past_v: the last velocities, likewise, shape (k, n).
        at: the place of the oldest one.
        q: measured positions of this tick, shape (nq,), m and rad.
        v: measured velocities of this tick, shape (n,), m/s and rad/s.
        grip: part of the commanded velocity that arrives in this tick, shape (n,).
    """

    random: np.random.Generator
    past_q: Vector
    past_v: Vector
    at: int
    q: Vector
    v: Vector
    grip: Vector


class Sensors:
    """Sensors of all robots, and the grip of their wheels.

    The torque loop reads its joints by itself; this is what the controllers are told.

    Attributes:
        perfect: whether everything is measured as it is, at once.
        slips: whether wheels slip.
    """

    def __init__(self, config: PlantConfig, team: Team, period: float) -> None:
        """Read the scenario's numbers; ``period`` [s] is that of ``see``."""
        self._config = config
        self._arms = _places(team.q_slices, [robot.arm_q for robot in team.robots])
        self._bases = _places(team.slices, [robot.base for robot in team.robots])
        self._n = team.n
        self._age = round(config.latency / period)  # steps
        self.perfect = not (config.encoder_step or config.velocity_noise or self._age)
        self.slips = config.base_slip > 0.0

    def begin(self, q: Vector, seed: int) -> SensorState:
        """Return the memory of a plant that has always been at rest at q, shape (nq,)."""
        past_q, past_v = np.tile(q, (self._age + 1, 1)), np.zeros((self._age + 1, self._n))
        random = np.random.default_rng(seed)
        still, whole = np.zeros(self._n), np.ones(self._n)
        state = SensorState(random, past_q, past_v, 0, q.copy(), still, whole)
        self.measure(state, q, state.v)
        return state

    def see(self, state: SensorState, q: Vector, v: Vector) -> None:
        """Keep the present positions (nq,) and velocities (n,) for later."""
        state.past_q[state.at], state.past_v[state.at] = q, v
        state.at = (state.at + 1) % len(state.past_q)

    def measure(self, state: SensorState, q: Vector, v: Vector) -> None:
        """Write what is measured at the end of a tick, and draw the grip of the next one.

        Args:
            state: whose ``q``, ``v`` and ``grip`` are written.
            q: true positions, shape (nq,).
            v: true velocities, shape (n,).
        """
        step, noise, slip = (
            self._config.encoder_step,
            self._config.velocity_noise,
            self._config.base_slip,
        )
        if self._age:
            q, v = state.past_q[state.at], state.past_v[state.at]
        state.q[:], state.v[:] = q, v
        if step:
            state.q[self._arms] = step * np.round(state.q[self._arms] / step)
        if noise:
            state.v += noise * state.random.standard_normal(state.v.size)
        if slip:
            lost = slip * state.random.uniform(0.0, 2.0, self._bases.size)
            state.grip[self._bases] = 1.0 - lost


def _places(wholes: Sequence[slice], parts: Sequence[slice]) -> Vector:
    """Return the places of a part of every robot's vector, in the vectors of all."""
    return np.concatenate(
        [
            np.arange(whole.start, whole.stop)[part]
            for whole, part in zip(wholes, parts, strict=True)
        ]
    )
