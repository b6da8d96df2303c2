"""The drives of one arm: they refuse what they cannot do, as Franka's do."""

from __future__ import annotations

import numpy as np

from lexstack.limits import JointLimits
from lexstack.types import Matrix, Vector

_TOLERANCE = 1e-3  # relative, beyond a limit
_NAMES = ("velocity", "acceleration", "jerk")


class Drive:
    """Looks at the positions that it is asked for at 1 kHz, and stops at a step.

    Velocity, acceleration and jerk are differences of the positions. Where one is beyond its limit
    the drive refuses everything from then on, brakes as hard as it can, and holds.

    Attributes:
        stopped: why it refuses everything; '': it follows.
        peaks: largest velocity, acceleration and jerk that it was asked for / limit, shape (3,).
    """

    def __init__(self, limits: JointLimits, q: Vector, period: float, *, reflex: bool) -> None:
        """Stand at a position, shape (n,); ``period`` [s] is that of the rows of ``follow``."""
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
        self.q, self._v, self._a = q.copy(), np.zeros_like(q), np.zeros_like(q)

    def stop(self, reason: str) -> None:
        """Refuse everything from now on: an emergency stop."""
        self.stopped = self.stopped or reason

    def follow(self, asked: Matrix) -> tuple[Matrix, int]:
        """Follow positions, one row per period, shape (k, n).

        Returns:
            The positions that the motors are led to, shape (k, n), and how many of them are those
            that were asked for: from there on the drive has stopped.
        """
        if self.stopped:
            return self._braked(asked), 0
        v, a, jerk = self._differences(asked)
        ratio = np.abs(np.stack([v, a, jerk], axis=1)) / self._most  # (k, 3, n)
        good = len(asked)
        if self._reflex and ratio.max() > 1.0:
            good, what, joint = np.argwhere(ratio > 1.0)[0].tolist()
            excess = ratio[good, what, joint]
            self.stopped = (
                f"reflex: {_NAMES[what]} of joint {joint + 1} is {excess:.3g} times its limit"
            )
        self.peaks = np.maximum(self.peaks, ratio[: good + 1].max(axis=(0, 2)))
        if good:
            self.q, self._v, self._a = asked[good - 1], v[good - 1], a[good - 1]
        if good == len(asked):
            return asked, good
        return np.concatenate([asked[:good], self._braked(asked[good:])]), good

    def _differences(self, asked: Matrix) -> tuple[Matrix, Matrix, Matrix]:
        """Return velocities, accelerations and jerks of positions, shape (k, n) each."""
        found, rows = [], asked
        for before in (self.q, self._v, self._a):
            rows = np.diff(rows, axis=0, prepend=before[None]) / self._period
            found.append(rows)
        return found[0], found[1], found[2]

    def _braked(self, asked: Matrix) -> Matrix:
        """Return positions that slow down at the acceleration limits, as many as ``asked``."""
        steps = np.arange(1, len(asked) + 1)[:, None]
        lost = steps * self._period * self._limits.acceleration
        v = np.sign(self._v) * np.maximum(np.abs(self._v) - lost, 0.0)
        q: Matrix = self.q + self._period * np.cumsum(v, axis=0)
        self._a = (v[-1] - (v[-2] if len(v) > 1 else self._v)) / self._period
        self.q, self._v = q[-1], v[-1]
        return q
