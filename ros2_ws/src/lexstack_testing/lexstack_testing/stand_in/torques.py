"""Arms that take torques: each keeps the last one that it was sent."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lexstack.types import Vector
from lexstack_sim.impedance import TorqueLoop


class HeldTorques:
    """A torque loop in which some arms have torques from outside; before the first, its own."""

    def __init__(
        self,
        loop: TorqueLoop,
        control: Vector,
        places: Mapping[str, NDArray[np.intp]],
        torques: Mapping[str, Vector],
    ) -> None:
        """Take the places of the arms in chi, and where their torques [N m] will stand."""
        self._loop, self._control = loop, control
        self._places, self._torques = places, torques

    def reset(self, q: Vector) -> None:
        """Start at rest at q, shape (n,)."""
        self._loop.reset(q)

    def update(self, q: Vector, v: Vector, q_star: Vector, v_star: Vector) -> None:
        """Write the control of the next period; all arguments have shape (n,)."""
        self._loop.update(q, v, q_star, v_star)
        for name, torques in self._torques.items():
            self._control[self._places[name]] = torques
