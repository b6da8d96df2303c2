"""The drives of one arm: they refuse what they cannot do, as Franka's do."""

from __future__ import annotations

import numpy as np

from lexstack.limits import JointLimits
from lexstack.types import Vector

_TOLERANCE = 1e-3  # relative, beyond a limit


class Drive:
    """Looks at the positions that it is asked for at 1 kHz, and stops at a step.

    Velocity, acceleration and jerk are differences of the positions. Where one is beyond its limit
    the drive refuses everything from then on, brakes as hard as it can, and holds.

    Attributes:
        stopped: why it refuses everything; '': it follows.
        peaks: largest velocity, acceleration and jerk that it was asked for / limit, shape (3,).
    """

    def __init__(self, limits: JointLimits, q: Vector, period: float, *, reflex: bool) -> None:
        """Stand at a position, shape (n,); ``period`` [s] is that of ``follow``."""
        self.stopped = ""
        self.peaks: Vector = np.zeros(3)
        self._limits = limits
        self._most = (1.0 + _TOLERANCE) * np.array(
            [limits.velocity, limits.acceleration, limits.jerk]
        )
        self._period = period
        self._reflex = reflex
        self.release(q)

    def release(self, q: Vector) -> None:
        """Follow again, from rest at a position, shape (n,)."""
        self.stopped = ""
        self._q, self._v, self._a = q.copy(), np.zeros_like(q), np.zeros_like(q)

    def stop(self, reason: str) -> None:
        """Refuse everything from now on: an emergency stop."""
        self.stopped = self.stopped or reason

    def follow(self, q: Vector) -> Vector:
        """Return the position that the motors are led to, shape (n,), for the one asked for."""
        period = self._period
        v = (q - self._q) / period
        a = (v - self._v) / period
        if not self.stopped:
            excess = self._excess(v, a)
            self.stopped = excess if self._reflex else ""
        if self.stopped:
            most = self._limits.acceleration * period
            v = self._v - np.clip(self._v, -most, most)
            a = (v - self._v) / period
            q = self._q + period * v
        self._q, self._v, self._a = q, v, a
        return q

    def _excess(self, v: Vector, a: Vector) -> str:
        """Return which limit a step of the positions is beyond, or ''."""
        found = np.array([v, a, (a - self._a) / self._period])
        ratio = np.abs(found) / self._most
        self.peaks = np.maximum(self.peaks, ratio.max(axis=1))
        if ratio.max() <= 1.0:
            return ""
        what, joint = np.argwhere(ratio > 1.0)[0]
        name = ("velocity", "acceleration", "jerk")[what]
        return f"reflex: {name} of joint {joint + 1} is {ratio[what, joint]:.3g} times its limit"
