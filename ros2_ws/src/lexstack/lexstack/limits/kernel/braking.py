"""Where a joint stops whose jerk is limited; ``stopping`` has the derivation of every line."""

from __future__ import annotations

from math import sqrt

from lexstack.compiled import compiled

_FAR = 1e100  # as in ``stopping``, which says why
_PASSES = 50
_ROUNDING = 1e-12


@compiled
def stopping_distance(speed: float, used: float, change: float) -> tuple[float, float]:
    """Return F(v, w') and its derivative by w', in units of S: ``_stopping_distance``."""
    v, c = speed + change, change - 0.5
    by_v, by_c = 1.0, 1.0  # derivatives of v and c
    moved = v
    if v < 0.0:
        square = c * c + 2.0 * v
        if c <= 0.0 or square <= 0.0:
            return moved, 1.0
        c, by_c = sqrt(square), (c + 1.0) / sqrt(square)
        v, by_v = 0.0, 0.0
    else:
        landing = sqrt(2.0 * v)
        if landing <= used and c <= -landing:
            return moved + landing * v / 3.0, 1.0 + 0.5 * landing
        if c < -used:
            c, by_c = -used, 0.0
    z, by_z = v + 0.5 * c * c, by_v + c * by_c
    if z < used * used:
        held, slope = z * sqrt(z), 1.5 * sqrt(z)
    else:
        held, slope = 0.5 * z * (z / used + used), z / used + 0.5 * used
    gained = c if c > 0.0 else 0.0
    distance = z * c - c * c * c / 6.0 + held + 0.5 * gained * gained
    by_change = by_z * (c + slope) + by_c * (z - 0.5 * c * c + gained)
    return moved + distance, 1.0 + by_change


@compiled
def stoppable_change(room: float, speed: float, used: float, least: float, largest: float) -> float:
    """Return max {w' in [least, largest]: F(v, w') <= d / dt}, or ``least``, in units of S.

    ``largest_stoppable_change``, line by line.
    """
    if speed > _FAR:
        return least
    distance, slope = stopping_distance(speed, used, largest)
    if distance <= room:
        return largest
    if stopping_distance(speed, used, least)[0] > room:
        return least
    change = largest
    for _ in range(_PASSES):
        change -= (distance - room) / slope
        if change <= least:
            break
        distance, slope = stopping_distance(speed, used, change)
        if distance - room <= _ROUNDING * (used + room):
            return change
    return least
