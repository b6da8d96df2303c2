"""Rotations through waypoints with continuous angular velocity and acceleration.

Between two waypoints the rotation is R_i exp(phi(s)), with phi a cubic in s. The angular velocities
at the waypoints are those for which the angular acceleration is continuous too; scipy finds them
(``RotationSpline``). Its rotations do not rest at the ends; so s is not the time, but

    s(t): rest -> rate 1 in the first interval, t in between, rate 1 -> rest in the last one

each a quintic whose second derivative is zero at both ends. Where the angular velocities at the
waypoints are given, s is the time, and the angular acceleration may jump there.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack.robots.spatial import log3
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, slots=True, eq=False)
class RotationPath:
    """Rotations through waypoints at times, at rest at both ends.

    Attributes:
        times: shape (N,), s.
        rotations: shape (N, 3, 3).
        cubics: phi = c_1 u + c_2 u^2 + c_3 u^3 with u the s since the waypoint, (N - 1, 3, 3).
        timed: whether s is the time.
    """

    times: Vector
    rotations: NDArray[np.float64]
    cubics: NDArray[np.float64]
    timed: bool = False

    @classmethod
    def through(
        cls, times: Vector, rotations: NDArray[np.float64], turning: Matrix | None = None
    ) -> RotationPath:
        """Return the path through rotations (N, 3, 3) at times (N,), the short way each.

        ``turning``: angular velocities there in the world, shape (N, 3), rad/s; None: smooth ones.
        """
        turns = np.array([log3(a.T @ b) for a, b in pairwise(rotations)])
        spans = np.diff(times)
        if turning is None:
            rates = _rates(times, rotations, turns)
        else:
            rates = np.einsum("kji,kj->ki", rotations, turning)  # in the body's axes
        cubics = np.empty((len(turns), 3, 3))
        for k, (turn, span) in enumerate(zip(turns, spans, strict=True)):
            # phi' at the ends from the angular velocity in the body's axes, w = J_r(phi) phi'.
            first = rates[k]
            last = np.linalg.solve(np.asarray(pin.Jexp3(turn)), rates[k + 1])
            cubics[k, 0] = first
            cubics[k, 1] = (3.0 * turn / span - 2.0 * first - last) / span
            cubics[k, 2] = (first + last - 2.0 * turn / span) / span**2
        return cls(times, rotations, cubics, turning is not None)

    def at(self, stamp: float) -> Matrix:
        """Return the rotation at a time [s] between the first and the last, shape (3, 3)."""
        k, u, _ = self._place(stamp)
        c = self.cubics[k]
        phi = ((c[2] * u + c[1]) * u + c[0]) * u
        return np.asarray(self.rotations[k] @ pin.exp3(phi))

    def rate(self, stamp: float) -> Vector:
        """Return the angular velocity in the world at such a time, shape (3,), rad/s."""
        k, u, pace = self._place(stamp)
        c = self.cubics[k]
        phi = ((c[2] * u + c[1]) * u + c[0]) * u
        slope = (3.0 * c[2] * u + 2.0 * c[1]) * u + c[0]
        left = np.asarray(pin.Jexp3(phi)).T
        return np.asarray(pace * (self.rotations[k] @ (left @ slope)))

    def _place(self, stamp: float) -> tuple[int, float, float]:
        """Return the interval, s since its start, and ds/dt."""
        last = len(self.times) - 2
        k = min(max(int(np.searchsorted(self.times, stamp, side="right")) - 1, 0), last)
        span = float(self.times[k + 1] - self.times[k])
        x = (stamp - float(self.times[k])) / span
        if self.timed:
            return k, x * span, 1.0
        if last == 0:
            s = x**3 * (10.0 + x * (6.0 * x - 15.0))
            return k, s * span, 30.0 * x * x * (1.0 - x) ** 2
        if k == 0:
            s, pace = _begun(x)
            return k, s * span, pace
        if k == last:
            s, pace = _begun(1.0 - x)
            return k, (1.0 - s) * span, pace
        return k, x * span, 1.0


def _begun(x: float) -> tuple[float, float]:
    """Return the quintic that leaves 0 at rest and reaches 1 at rate 1, and its slope."""
    return x**3 * (6.0 + x * (3.0 * x - 8.0)), x * x * (18.0 + x * (15.0 * x - 32.0))


def _rates(times: Vector, rotations: NDArray[np.float64], turns: Matrix) -> Matrix:
    """Return the angular velocity at each waypoint in its own axes, shape (N, 3), rad/s."""
    if len(times) == 2:
        return np.asarray(np.array([turns[0], turns[0]]) / (times[1] - times[0]))
    from scipy.spatial.transform import (  # noqa: PLC0415  # loads in 0.3 s: when asked
        Rotation,
        RotationSpline,
    )

    spline = RotationSpline(times - times[0], Rotation.from_matrix(rotations))
    return np.asarray(spline(times - times[0], 1))
