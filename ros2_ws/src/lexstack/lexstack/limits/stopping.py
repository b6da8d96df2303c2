"""How fast a joint may go towards a limit in front of which it must stop, in discrete time.

With acceleration alone ``approach_speed``; with jerk ``largest_stoppable_change``, of which
``jerk_bounds`` makes the box of all joints.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from lexstack.types import Vector

_FAR = 1e100  # a speed beyond this is none
_PASSES = 50  # of the search, which has not been seen to need more than seven
_ROUNDING = 1e-12  # of the search, relative
_KEPT = 1e-9  # of the room, relative: exceeded by no more it is kept


def approach_speed(room: Vector, rate: Vector, dt: float) -> Vector:
    """Return u(d), the speed from which ``rate`` still stops within the room d, in steps of dt.

    u(d) = sgn(d) (-a dt + sqrt(a^2 dt^2 + 2 a |d|)) is odd and increasing. With room in velocity
    and rate in jerk, it is the acceleration from which a velocity limit is still kept.

    Args:
        room: signed distance to the limit, shape (n,).
        rate: the largest change of the result per second, shape (n,), positive.
        dt: control period [s].
    """
    # The printed form subtracts nearly equal numbers close to the limit; this quotient is equal to
    # it, has no cancellation, and carries the sign of d by itself.
    reach = rate * dt
    doubled = rate * room
    doubled += doubled
    root = np.abs(doubled)
    root += reach * reach
    np.sqrt(root, out=root)
    root += reach
    return np.divide(doubled, root, out=root)


def largest_stoppable_change(
    room: float, speed: float, used: float, least: float, largest: float
) -> float:
    """Return max {w' in [least, largest]: F(v, w') <= d / dt}, or ``least``; in units of S.

    By Newton's method from above: F is convex, no step goes too far.
    """
    if speed > _FAR:
        return least
    goes, slope = _stopping_distance(speed, used, largest)
    if goes <= room:
        return largest
    if _stopping_distance(speed, used, least)[0] > room:
        return least
    change = largest
    for _ in range(_PASSES):
        change -= (goes - room) / slope
        if change <= least:
            break
        goes, slope = _stopping_distance(speed, used, change)
        if goes - room <= _ROUNDING * (used + room):
            return change
    return least


def keeps_room(room: float, speed: float, used: float, change: float) -> bool:
    """Return whether F(v, w') <= d / dt, within rounding; in units of S."""
    return speed <= _FAR and _stopping_distance(speed, used, change)[0] - room <= _KEPT * (
        used + abs(room)
    )


def _stopping_distance(speed: float, used: float, change: float) -> tuple[float, float]:
    """Return F(v, w') and its derivative by w', in units of S."""
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
    gained = max(c, 0.0)
    distance = z * c - c * c * c / 6.0 + held + 0.5 * gained * gained
    by_change = by_z * (c + slope) + by_c * (z - 0.5 * c * c + gained)
    return moved + distance, 1.0 + by_change
