"""The profiles of alpha: from 0 to 1 over the unit interval."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def quintic(s: float) -> float:
    """Return 10 s^3 - 15 s^4 + 6 s^5: velocity and acceleration zero at both ends."""
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


def cosine(s: float) -> float:
    """Return (1 - cos(pi s)) / 2: velocity zero at both ends."""
    return 0.5 * (1.0 - float(np.cos(np.pi * s)))


def linear(s: float) -> float:
    """Return s."""
    return s


PROFILES: dict[str, Callable[[float], float]] = {
    "quintic": quintic,
    "cosine": cosine,
    "linear": linear,
}
"""alpha over the elapsed part of the duration, by name."""


def alpha(profile: str, elapsed: float, duration: float) -> float:
    """Return alpha after ``elapsed`` of ``duration`` seconds, clamped to [0, 1]."""
    return PROFILES[profile](min(max(elapsed / duration, 0.0), 1.0))
