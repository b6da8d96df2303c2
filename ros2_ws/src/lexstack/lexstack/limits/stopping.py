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

    F is that of ``jerk_bounds``: how far the joint still goes if its velocity changes by w' now and
    it then brakes with the full jerk. Divided by S = j dt^2, velocities, changes of velocity and
    distances / dt are plain numbers. The root of F = d / dt is found by Newton's method from above,

        w' <- w' - (F(v, w') - d / dt) / F'(w')

    F increases with w' and is convex, so every iterate stays above the root and the next one is
    nearer: no step goes too far, and none can leave [least, largest] but for rounding.

    Args:
        room: d / (S dt), not negative.
        speed: v / S, towards the limit.
        used: A / S, the largest change of velocity that the law uses.
        least: change that brakes hardest.
        largest: change that the other limits allow.
    """
    if speed > _FAR:
        return least
    # The two ends first. If even the hardest braking goes too far, that is the best there is; after
    # this line the root is between the two, and Newton's method may start at the upper one.
    distance, slope = _stopping_distance(speed, used, largest)
    if distance <= room:
        return largest
    if _stopping_distance(speed, used, least)[0] > room:
        return least
    change = largest
    for _ in range(_PASSES):
        change -= (distance - room) / slope  # slope >= 1: the tick at v' = v + w' alone counts 1
        if change <= least:
            break
        distance, slope = _stopping_distance(speed, used, change)
        # From above F reaches d only in the limit, so what is left must be allowed as rounding: it
        # is relative to the numbers in it, and 1000 times smaller than what ``keeps_room`` allows.
        if distance - room <= _ROUNDING * (used + room):
            return change
    return least


def keeps_room(room: float, speed: float, used: float, change: float) -> bool:
    """Return whether F(v, w') <= d / dt, within rounding; in units of S."""
    return speed <= _FAR and _stopping_distance(speed, used, change)[0] - room <= _KEPT * (
        used + abs(room)
    )


def _stopping_distance(speed: float, used: float, change: float) -> tuple[float, float]:
    """Return F(v, w') and its derivative by w', in units of S.

    F = v' + D: one tick at v' = v + w', then the distance D of a continuous motion to rest, which
    begins with v' and the acceleration c = w' - 1/2. w' is the mean acceleration of the tick, and
    with the jerk -1 the acceleration is lower by 1/2 at the end of the tick. The motion has three
    parts, with z = v' + c^2 / 2, the speed that it would have where its acceleration is 0:

        jerk -1, from c down to -P     distance  z (c + P) - (c^3 + P^3) / 6
        acceleration -P                distance  (z / P - P) z / 2
        jerk +1, up to rest            distance  P^3 / 6

    P^2 = min(A^2, z): where A is not reached, P^2 = z and the second part is empty. The sum is

        D = z c - c^3 / 6 + (z / P + P) z / 2,    (z / P + P) z / 2 = z^(3/2) where P^2 = z

    and max(c, 0)^2 / 2 is added: while the joint still gets faster, its steps at the velocity of
    their end go further than the continuous motion (see ``jerk_bounds``).
    """
    # Both grow by 1 with w'.
    v, c = speed + change, change - 0.5
    by_v, by_c = 1.0, 1.0  # derivatives of v and c
    moved = v
    # Away from the limit: the joint turns if its acceleration lasts until v' = 0. It has then
    # c^2 + 2 v' for the square of its acceleration, and the rest of the motion begins there.
    if v < 0.0:
        square = c * c + 2.0 * v
        if c <= 0.0 or square <= 0.0:
            return moved, 1.0
        c, by_c = sqrt(square), (c + 1.0) / sqrt(square)
        v, by_v = 0.0, 0.0
    else:
        # From the acceleration -sqrt(2 v') the jerk +1 alone leads to rest, after the distance
        # sqrt(2 v') v' / 3. Harder braking would make the joint go back, so the motion is taken to
        # brake no harder than that, and no harder than A.
        landing = sqrt(2.0 * v)
        if landing <= used and c <= -landing:
            return moved + landing * v / 3.0, 1.0 + 0.5 * landing
        if c < -used:
            c, by_c = -used, 0.0
    # The sum above, and its derivative by the chain rule: D_z = c + slope and
    # D_c = z - c^2 / 2 + max(c, 0), with ``held`` the term of P and ``slope`` its derivative by z.
    z, by_z = v + 0.5 * c * c, by_v + c * by_c
    if z < used * used:
        held, slope = z * sqrt(z), 1.5 * sqrt(z)
    else:
        held, slope = 0.5 * z * (z / used + used), z / used + 0.5 * used
    gained = max(c, 0.0)
    distance = z * c - c * c * c / 6.0 + held + 0.5 * gained * gained
    by_change = by_z * (c + slope) + by_c * (z - 0.5 * c * c + gained)
    return moved + distance, 1.0 + by_change
