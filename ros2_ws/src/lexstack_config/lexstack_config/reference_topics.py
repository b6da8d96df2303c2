"""The schema of what topics of references leave open: when a twist is late, how fast a path is."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.options import Positive


@dataclass(frozen=True, slots=True)
class ReferenceTopicsConfig:
    """What messages of references do not say themselves."""

    # s of simulated time after which a twist without a successor fades to zero
    twist_timeout: Positive = 0.2
    twist_linear: Positive = 1.0  # m/s2, with which a reference follows a twist
    twist_angular: Positive = 2.0  # rad/s2, with which a reference follows a twist
    path_speed: Positive = 0.3  # m/s, at most, along a path without stamps
    path_turn: Positive = 0.5  # rad/s, at most, along a path without stamps
