"""Bounds on chi that are feasible at every step: position, velocity and acceleration together.

T(31) intersects three boxes and is empty as soon as a joint moves towards a position limit faster
than it can brake. Here the position limit enters through the speed from which the joint can still
stop in front of it, per joint with v the velocity applied last, d the room left, a the
acceleration limit and dt the control period:

    u(d) = sgn(d) (-a dt + sqrt(a^2 dt^2 + 2 a |d|))
    U = clip(u(q_max - q), -v_max, v_max)        L = clip(u(q_min - q), -v_max, v_max)
    lower = clip(L, v - a dt, v + a dt)          upper = clip(U, v - a dt, v + a dt)

u is odd and increasing, clipping is monotone: lower <= upper from every state. In discrete time,
q(k+1) = q(k) + dt chi, moving at u(d) leaves the room d' with u(d') >= u(d) - a dt, so the box of
the next step always reaches below U again: whoever is inside the limits stays inside.

With jerk limits, and where the last acceleration is known, the law is ``jerk_bounds.JerkLaw``.

``limits/kernel`` has the same as compiled loops, which replace the arrays below where numba is
there, and give the same bits.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lexstack.compiled import kernel
from lexstack.limits.jerk_bounds import JerkLaw
from lexstack.limits.joint_limits import Bounds, JointLimits
from lexstack.limits.stopping import approach_speed
from lexstack.types import Vector

__all__ = [
    "Bounds",
    "JointLimits",
    "approach_speed",
    "can_stop",
    "is_viable",
    "target_bounds",
    "viable_bounds",
]

_KERNEL = "lexstack.limits.kernel.box"
_FLOAT = np.dtype(np.float64)
_KEPT = 1e-9  # m, rad, m/s, rad/s: a limit exceeded by no more is kept


def viable_bounds(
    position: Vector,
    limits: JointLimits,
    dt: float,
    applied: Vector,
    sent: Vector | None = None,
    acceleration: Vector | None = None,
) -> Bounds:
    """Return the box of all chi after which the joints can still stop within their limits.

    Takes the place of T(31). Where the joint starts outside its position limits or above its
    velocity limit, the box leads back at the acceleration limit. ``lower <= upper`` holds for
    every finite input; a NaN in the input is a NaN, hence an empty interval, in the output.

    With ``acceleration``, the acceleration of two boxes in a row differs by at most jerk dt on
    every joint with a jerk limit; joints without one keep the box that they had.

    Args:
        position: q*, the integral of the commands, shape (n,), m and rad.
        limits: of all robots.
        dt: control period [s].
        applied: the velocity that the plant applied last, shape (n,).
        sent: the velocity that was sent last, if it may not have arrived. The box then keeps the
            acceleration limit whichever of the two the plant has, except on joints where they
            are too far apart for that: there it is the box of ``applied``.
        acceleration: of the last tick, (applied - the velocity applied before it) / dt, shape
            (n,), m/s^2 and rad/s^2; None: jerk is not limited.
    """
    fast = kernel(_KERNEL)
    if fast is None or not position.dtype is applied.dtype is _FLOAT:
        return _in_arrays(position, limits, dt, applied, sent, acceleration)
    box, last = np.empty((2, position.size)), applied if sent is None else sent
    law, free = (None, None) if acceleration is None else _jerk_law(limits, dt)
    if law is None:
        fast.command(position, limits.table, dt, applied, last, box)
    else:
        of_law = (position, limits.table, law.table, free, dt)
        fast.with_jerk(*of_law, applied, last, last is not applied, acceleration, box)
    return Bounds.of(box)


def _in_arrays(
    position: Vector,
    limits: JointLimits,
    dt: float,
    applied: Vector,
    sent: Vector | None,
    acceleration: Vector | None,
) -> Bounds:
    """Return what ``viable_bounds`` does, by numpy."""
    law, free = _jerk_law(limits, dt)
    if acceleration is None or law is None:
        return _without_jerk(position, limits, dt, applied, sent)
    least, largest = law.changes(position, applied, acceleration * dt)
    least += applied
    largest += applied
    if sent is not None and sent is not applied:
        reach = limits.acceleration * dt
        least, largest = _common(least, largest, sent - reach, sent + reach)
    if free.any():
        box = _without_jerk(position, limits, dt, applied, sent)
        least, largest = np.where(free, box.lower, least), np.where(free, box.upper, largest)
    return _frozen(least, largest)


def target_bounds(position: Vector, limits: JointLimits, dt: float) -> Bounds:
    """Return the viable bounds without the acceleration box, T(35): of a target, not a command.

    Args:
        position: q*, shape (n,), m and rad.
        limits: of all robots.
        dt: control period [s].
    """
    fast = kernel(_KERNEL)
    if fast is None or position.dtype is not _FLOAT:
        return _target_in_arrays(position, limits, dt)
    box = np.empty((2, position.size))
    fast.target(position, limits.table, dt, box)
    return Bounds.of(box)


def _target_in_arrays(position: Vector, limits: JointLimits, dt: float) -> Bounds:
    """Return what ``target_bounds`` does, by numpy."""
    box = _stoppable(position, limits, dt)
    return _frozen(box[: position.size], box[position.size :])


def is_viable(
    position: Vector, limits: JointLimits, dt: float, applied: Vector, acceleration: Vector
) -> NDArray[np.bool_]:
    """Return which joints can keep all their limits from this state on, shape (n,).

    The arguments are those of ``can_stop``.
    """
    sides = can_stop(position, limits, dt, applied, acceleration)
    viable = sides[: position.size] & sides[position.size :]
    slow = np.abs(applied) <= limits.velocity + limits.acceleration * dt + _KEPT
    law, free = _jerk_law(limits, dt)
    if law is None:
        return viable & slow
    with_jerk = law.viable(position, applied, acceleration * dt)
    return np.where(free, viable & slow, with_jerk)


def can_stop(
    position: Vector, limits: JointLimits, dt: float, applied: Vector, acceleration: Vector | None
) -> NDArray[np.bool_]:
    """Return which joints can stop in front of their lower, then their upper limits, (2n,).

    Args:
        position: q*, shape (n,), m and rad.
        limits: of all robots; where jerk is infinite, the acceleration of the last tick is free.
        dt: control period [s].
        applied: the velocity that the plant applied last, shape (n,).
        acceleration: of the last tick, shape (n,), m/s^2 and rad/s^2; None: jerk is not limited.
    """
    room = limits.positions - np.concatenate((position, position))
    room[: position.size] *= -1.0
    speed = np.concatenate((-applied, applied))
    stops: NDArray[np.bool_] = room >= -_KEPT
    stops &= speed <= approach_speed(room, limits.rates, dt) + limits.rates * dt + _KEPT
    law, free = _jerk_law(limits, dt)
    if acceleration is None or law is None:
        return stops
    with_jerk = law.stops(position, applied, acceleration * dt)
    return np.where(np.tile(free, 2), stops, with_jerk)


def _without_jerk(
    position: Vector, limits: JointLimits, dt: float, applied: Vector, sent: Vector | None
) -> Bounds:
    """Return the box of position, velocity and acceleration limits; see ``viable_bounds``."""
    box = _stoppable(position, limits, dt)
    reach = limits.acceleration * dt
    lowest, highest = applied - reach, applied + reach
    if sent is not None:
        lowest, highest = _common(lowest, highest, sent - reach, sent + reach)
    n = position.size
    lower, upper = box[:n], box[n:]
    for side in (lower, upper):
        np.maximum(side, lowest, out=side)
        np.minimum(side, highest, out=side)
    return _frozen(lower, upper)


@lru_cache(maxsize=64)
def _jerk_law(limits: JointLimits, dt: float) -> tuple[JerkLaw | None, NDArray[np.bool_]]:
    """Return the law, None where no joint has a jerk limit; and which joints have none, (n,)."""
    free = np.isinf(limits.jerk)
    if free.all():
        return None, free
    position = (limits.position_lower, limits.position_upper)
    law = JerkLaw(position, limits.velocity, limits.acceleration, limits.jerk, dt)
    return law, free


def _stoppable(position: Vector, limits: JointLimits, dt: float) -> Vector:
    """Return L then U, shape (2n,): how fast each joint may move towards either limit."""
    room = limits.positions - np.concatenate((position, position))
    speed = approach_speed(room, limits.rates, dt)
    np.minimum(speed, limits.speeds, out=speed)
    return np.maximum(speed, -limits.speeds, out=speed)


def _common(
    lower: Vector, upper: Vector, other_lower: Vector, other_upper: Vector
) -> tuple[Vector, Vector]:
    """Return the intersection of two boxes, and the first one on joints where it is empty."""
    lowest = np.maximum(lower, other_lower)
    highest = np.minimum(upper, other_upper)
    apart = lowest > highest
    if apart.any():
        return np.where(apart, lower, lowest), np.where(apart, upper, highest)
    return lowest, highest


def _frozen(lower: Vector, upper: Vector) -> Bounds:
    """Return read-only bounds."""
    lower.setflags(write=False)
    upper.setflags(write=False)
    return Bounds(lower, upper)
