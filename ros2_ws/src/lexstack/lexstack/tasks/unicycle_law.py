"""A law that drives a unicycle to a pose: for bases that cannot go sideways."""

from __future__ import annotations

import math

from lexstack.robots.spatial import wrap

_SHAPE = 4.0  # h of the Lyapunov function; at 4 the angles decay twice as fast as the distance
_PLACE = 2e-3  # m: nearer than this the base only turns, to the heading that is asked for


def unicycle_rates(
    gap: tuple[float, float], yaw: float, desired_yaw: float, gain: float
) -> tuple[float, float]:
    """Return the forward speed v [m/s] and the yaw rate w [rad/s] that lead a unicycle to a pose.

    In polar coordinates about the goal, with the distance r, the bearing a of the goal seen from
    the heading, and the bearing b of the same line seen from the desired heading::

        r' = -v cos a,   a' = v sin a / r - w,   b' = v sin a / r
        v  = k r cos a,  w = c a + k (sin a cos a / a) (a + h b),   c = 2 k sqrt(h)

    The function V = (r^2 + a^2 + h b^2) / 2 decreases: along the motion the terms in sin a cos a
    cancel and V' = -k r^2 cos(a)^2 - c a^2 <= 0. Where V' = 0, a = 0 and r cos a = 0; staying
    there asks for a' = -k h b = 0, so b = 0 too: by LaSalle's principle r, a and b all go to 0
    (M. Aicardi, G. Casalino, A. Bicchi, A. Balestrino, 1995). With this c the angles decay with
    the double root k sqrt(h), faster than r with k.

    Any positive factor on (v, w) only changes the pace: a caller may shorten both alike to keep
    limits. Within 2 mm the bearing says nothing any more, and the base turns where it stands.

    Args:
        gap: goal minus present position in the world frame, m.
        yaw: present heading, rad.
        desired_yaw: heading at the goal, rad.
        gain: k > 0, 1/s.
    """
    distance = math.hypot(*gap)
    turn = 2.0 * gain * math.sqrt(_SHAPE)
    remaining = wrap(desired_yaw - yaw)
    if distance <= _PLACE:
        return 0.0, turn * remaining
    bearing = math.atan2(gap[1], gap[0])
    a, b = wrap(bearing - yaw), wrap(bearing - desired_yaw)
    ratio = math.sin(a) / a if a else 1.0
    v = gain * distance * math.cos(a)
    w = turn * a + gain * ratio * math.cos(a) * (a + _SHAPE * b)
    # From twice that distance on the heading takes over smoothly: 0 at 2 mm, 1 at 4 mm.
    share = min((distance - _PLACE) / _PLACE, 1.0)
    share *= share * (3.0 - 2.0 * share)
    return v * share, share * w + (1.0 - share) * turn * remaining
