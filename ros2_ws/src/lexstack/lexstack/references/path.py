"""Times for a path that has none: as fast as stated speeds allow."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from lexstack.references.spline import Spline, base_spline
from lexstack.types import Matrix, Vector

_SAME = 1e-6  # m, rad: two places that are nearer are one
_SAMPLES = 16  # of each interval, for the largest speed


def path_at_speed(start: float, places: Matrix, speed: float, turn: float) -> Spline:
    """Return the way of a base through places that never exceeds a speed nor a rate of turn.

    Args:
        start: when it begins [s].
        places: x [m], y [m], yaw [rad], shape (N, 3).
        speed: m/s.
        turn: rad/s.

    Raises:
        InputError: places that make no way.
    """
    places = np.array(places, dtype=np.float64)
    places[:, 2] = np.unwrap(places[:, 2])
    limits = np.array([speed, turn])
    kept = [0]
    for k in range(1, len(places)):
        if np.abs(places[k] - places[kept[-1]]).max() > _SAME:
            kept.append(k)
    places = places[kept]
    if len(places) == 1:
        return base_spline(np.array([start, start + 1.0]), np.repeat(places, 2, axis=0))
    spans = [float((_ways(b - a) / limits).max()) for a, b in pairwise(places)]
    relative = np.concatenate(([0.0], np.cumsum(spans)))
    spline = base_spline(relative, places)
    samples = np.concatenate(
        [np.linspace(a, b, _SAMPLES, endpoint=False)[1:] for a, b in pairwise(relative)]
    )
    rates = [spline.rate(float(time)) for time in samples]
    longer = max(float((_ways(rate) / limits).max()) for rate in rates if rate is not None)
    return base_spline(start + max(longer, 1.0) * relative, places)


def _ways(change: Vector) -> Vector:
    """Return distance and turn of a change of place, shape (2,), m and rad."""
    return np.array([np.hypot(change[0], change[1]), abs(change[2])])
