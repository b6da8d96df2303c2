"""The profiles of alpha: how a blend comes from 0 to 1."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lexstack.transition.time_optimal import FadingGap, Progress, advanced


class Profile(Protocol):
    """How alpha rises from tick to tick."""

    def advanced(
        self,
        before: Progress,
        elapsed: float,
        duration: float,
        gap: Callable[[], FadingGap],
    ) -> Progress:
        """Return the progress of a tick.

        Args:
            before: of the tick before.
            elapsed: since the blend began [s].
            duration: of the blend [s].
            gap: returns what fades, and how fast the joints may let it.
        """
        ...


@dataclass(frozen=True, slots=True)
class TimedProfile:
    """alpha as a function of the elapsed part of the duration alone: it is known ahead.

    Attributes:
        curve: from [0, 1] to [0, 1].
    """

    curve: Callable[[float], float]

    def alpha(self, elapsed: float, duration: float) -> float:
        """Return alpha after ``elapsed`` of ``duration`` seconds, clamped to [0, 1]."""
        return self.curve(min(max(elapsed / duration, 0.0), 1.0))

    def advanced(
        self,
        before: Progress,
        elapsed: float,
        duration: float,
        gap: Callable[[], FadingGap],
    ) -> Progress:
        """Return alpha of a tick, whatever it was before."""
        return Progress(self.alpha(elapsed, duration))


class TimeOptimal:
    """As fast as the joints' acceleration and jerk limits let the gap fade, whatever the duration.

    alpha depends on the source's motion until then, so it is not known ahead.
    """

    def advanced(
        self,
        before: Progress,
        elapsed: float,
        duration: float,
        gap: Callable[[], FadingGap],
    ) -> Progress:
        """Return the progress one tick later."""
        return advanced(before, gap())


def quintic(s: float) -> float:
    """Return 10 s^3 - 15 s^4 + 6 s^5: velocity and acceleration zero at both ends."""
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


def cosine(s: float) -> float:
    """Return (1 - cos(pi s)) / 2: velocity zero at both ends."""
    return 0.5 * (1.0 - float(np.cos(np.pi * s)))


def linear(s: float) -> float:
    """Return s."""
    return s


PROFILES: dict[str, Profile] = {
    "quintic": TimedProfile(quintic),
    "cosine": TimedProfile(cosine),
    "linear": TimedProfile(linear),
    "time_optimal": TimeOptimal(),
}
"""The profiles by the name that a configuration uses."""


def alpha(profile: str, elapsed: float, duration: float) -> float:
    """Return alpha of a profile that is known ahead, after ``elapsed`` of ``duration`` seconds.

    Raises:
        TypeError: ``time_optimal`` is not known ahead.
    """
    timed = PROFILES[profile]
    if not isinstance(timed, TimedProfile):
        raise TypeError(f"{profile}: its alpha is not known ahead")
    return timed.alpha(elapsed, duration)
