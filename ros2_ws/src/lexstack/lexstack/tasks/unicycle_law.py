"""A law that drives a unicycle to a pose: for bases that cannot go sideways."""

from __future__ import annotations

import math

from lexstack.robots.spatial import wrap

_SHAPE = 4.0  # h of the Lyapunov function; at 4 the angles decay twice as fast as the distance
_LATERAL = 10.0  # 1/m2, of the tracking law: how strongly it turns for an error to the side
_SOON = 1e-4  # s, of the difference quotient along the motion
_SHARE = 0.5  # of the accelerations; the rest is for the changes of the pace itself
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

    A goal that is behind is reached in reverse: both headings then count from the rear. The choice
    is made where |a| = pi/2, and is never taken back: there cos a = 0 and a' = -c a, so the bearing
    leaves that border on the side on which it is.

    Any positive factor on (v, w) only changes the pace: a caller may shorten both alike to keep
    limits. Within 3 mm the bearing says nothing any more, and the base turns to its heading.

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
    bearing, sign = math.atan2(gap[1], gap[0]), 1.0
    if abs(wrap(bearing - yaw)) > 0.5 * math.pi:
        bearing, sign = bearing + math.pi, -1.0
    a, b = wrap(bearing - yaw), wrap(bearing - desired_yaw)
    ratio = math.sin(a) / a if a else 1.0
    v = sign * gain * distance * math.cos(a)
    w = turn * a + gain * ratio * math.cos(a) * (a + _SHAPE * b)
    # Between 4 and 3 mm the heading takes over; the base drives on, down to 2 mm. Did both end
    # at the same distance, the rest of the turn would wait for a motion that fades.
    share = min((distance - _PLACE) / _PLACE, 1.0)
    bent = max(2.0 * share - 1.0, 0.0)
    return v * share, bent * w + (1.0 - bent) * turn * remaining


def paced(
    gap: tuple[float, float],
    yaw: float,
    desired_yaw: float,
    gain: float,
    limits: tuple[tuple[float, float], tuple[float, float]],
) -> tuple[float, float]:
    """Return ``unicycle_rates``, both shortened alike so that a base can follow them.

    First within the speeds. Then, with their derivative d along the motion, to s (v, w): that is
    passed through at s times the pace, so its derivative is about s^2 d, which
    s = (1 + |d / (share a)|^2)^(-1/4) keeps within the accelerations a. Both factors are positive,
    so the proof of ``unicycle_rates`` holds.

    Args:
        gap: as there.
        yaw: as there.
        desired_yaw: as there.
        gain: as there.
        limits: of v and w [m/s, rad/s], and of their derivatives [m/s^2, rad/s^2].
    """
    speeds, accelerations = limits

    def fast(gap: tuple[float, float], yaw: float) -> tuple[float, float]:
        v, w = unicycle_rates(gap, yaw, desired_yaw, gain)
        factor = math.hypot(1.0, v / speeds[0], w / speeds[1])  # smooth, unlike a maximum
        return v / factor, w / factor

    v, w = fast(gap, yaw)
    x, y = gap[0] - _SOON * v * math.cos(yaw), gap[1] - _SOON * v * math.sin(yaw)
    ahead = fast((x, y), yaw + _SOON * w)
    rates = (
        (one - other) / (_SOON * _SHARE * a)
        for one, other, a in zip(ahead, (v, w), accelerations, strict=True)
    )
    factor = math.hypot(1.0, *rates) ** -0.5
    return factor * v, factor * w


def tracking_rates(
    gap: tuple[float, float], yaw: float, desired: tuple[float, float, float], gain: float
) -> tuple[float, float]:
    """Return v [m/s] and w [rad/s] that keep a unicycle on a moving pose.

    With the error e in the axes of the unicycle (ahead, left, yaw) and v_d, w_d of the pose::

        v = v_d cos e_yaw + k1 e_ahead
        w = w_d + k2 v_d (sin e_yaw / e_yaw) e_left + k1 e_yaw

    V = (k2 (e_ahead^2 + e_left^2) + e_yaw^2) / 2 has V' = -k1 (k2 e_ahead^2 + e_yaw^2), and where
    v_d or w_d stays away from 0, all of e goes to 0 (C. Canudas de Wit, C. Samson, 1993). With
    k1 = 2 gain and k2 = ``_LATERAL`` the errors of a straight path decay as a damped pair.

    Args:
        gap: position of the pose minus that of the unicycle in the world frame, m.
        yaw: present heading, rad.
        desired: yaw of the pose [rad], its v_d [m/s] and w_d [rad/s].
        gain: > 0, 1/s.
    """
    desired_yaw, v_d, w_d = desired
    cos, sin = math.cos(yaw), math.sin(yaw)
    ahead, left = cos * gap[0] + sin * gap[1], cos * gap[1] - sin * gap[0]
    turn = wrap(desired_yaw - yaw)
    ratio = math.sin(turn) / turn if turn else 1.0
    first = 2.0 * gain
    v = v_d * math.cos(turn) + first * ahead
    return v, w_d + _LATERAL * v_d * ratio * left + first * turn
