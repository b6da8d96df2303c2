"""How long a joint takes from rest to rest, as quick as velocity and acceleration let it."""

from __future__ import annotations

import numpy as np

from lexstack.types import Vector


def travel_time(distance: Vector, velocity: Vector, acceleration: Vector) -> Vector:
    """Return the least times of joints that move by themselves, shape (n,), s.

    A joint speeds up, moves at its limit where the way is long enough for that, and brakes.

    Args:
        distance: shape (n,), rad or m, of either sign.
        velocity: limits, > 0, shape (n,).
        acceleration: limits, > 0, shape (n,).
    """
    way = np.abs(distance)
    ramps = velocity * velocity / acceleration  # the way of speeding up and braking
    long = way / velocity + velocity / acceleration
    return np.asarray(np.where(way > ramps, long, 2.0 * np.sqrt(way / acceleration)))
