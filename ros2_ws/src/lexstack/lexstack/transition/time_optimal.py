"""The fastest alpha: as fast as the joints' acceleration and jerk limits let the gap fade."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.limits.stopping import approach_speed
from lexstack.types import Vector

_ARRIVED = 1e-4  # of the gap: the braking law comes closer by a constant factor a tick


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a blend is.

    Attributes:
        alpha: in [0, 1].
        rate: its speed [1/s].
    """

    alpha: float = 0.0
    rate: float = 0.0


@dataclass(frozen=True, slots=True)
class FadingGap:
    """What fades in a blend, and how fast the joints may let it.

    Attributes:
        delta: the gap that was latched, shape (n,), m/s and rad/s.
        drift: d chi_S/dt, shape (n,), m/s^2 and rad/s^2.
        acceleration: limits of the joints, shape (n,), m/s^2 and rad/s^2.
        jerk: the same, m/s^3 and rad/s^3.
        dt: control period [s].
    """

    delta: Vector
    drift: Vector
    acceleration: Vector
    jerk: Vector
    dt: float


def advanced(progress: Progress, fading: FadingGap) -> Progress:
    """Return the progress one tick later, as fast as every joint allows.

    The command chi_S + (1 - alpha) delta accelerates by d chi_S/dt - alpha' delta. With what the
    source itself needs set aside, joint i allows

        alpha' <= (a_i - |d chi_S,i/dt|) / |delta_i|      |alpha''| <= j_i / |delta_i|

    and alpha comes to rest at 1 by the law that keeps joints off their position limits.

    Args:
        progress: of the tick before.
        fading: the gap, and the limits.
    """
    gap, dt = np.maximum(np.abs(fading.delta), 1e-9), fading.dt
    spare = np.maximum(fading.acceleration - np.abs(fading.drift), 0.0)
    fastest = float(np.min(spare / gap))
    change = float(np.min(fading.jerk / gap))
    if not np.isfinite(change):
        change = 1e9
    room = 1.0 - progress.alpha
    braking = float(approach_speed(np.array([room]), np.array([change]), dt)[0])
    rate = min(progress.rate + change * dt, fastest, braking)
    alpha = progress.alpha + rate * dt
    return Progress(1.0, 0.0) if alpha >= 1.0 - _ARRIVED else Progress(alpha, rate)
