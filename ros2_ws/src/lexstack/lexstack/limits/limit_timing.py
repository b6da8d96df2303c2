"""Which joints cannot keep new limits at once, and for how long.

Let e be the distance of a joint outside a limit, v its outward velocity and r^2 = v^2 + 2 a e. A
joint that accelerates inward with a, up to its velocity limit, crosses the limit after

    t = (v + r) / a  where r <= v_max,  else  (v + v_max) / a + (r^2 - v_max^2) / (2 a v_max)

In steps of dt the joint is ahead of this continuous motion, so t is rounded up to whole ticks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lexstack.limits.joint_limits import JointLimits
from lexstack.limits.viable_bounds import can_stop
from lexstack.types import Vector

# m, rad: a limit exceeded by no more is kept, as in ``can_stop``, so both agree on what is inside.
# Also in ticks, see ``LimitTiming.of``.
_KEPT = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """The motion of the joints at one tick, as ``viable_bounds`` needs it.

    Attributes:
        position: q*, shape (n,), m and rad.
        applied: the velocity that the plant applied last, shape (n,), m/s and rad/s.
        dt: control period [s].
        acceleration: of the last tick, shape (n,), or None where jerk is not limited.
    """

    position: Vector
    applied: Vector
    dt: float
    acceleration: Vector | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LimitTiming:
    """Which joints are late, and by how much, shape (2n,): first the lower, then the upper limits.

    A joint is late at a limit if it is outside, or cannot stop in front of it.

    Attributes:
        fast: whether it is in front of the limit, but too fast to stop with the new acceleration,
            where the old one was larger.
        ticks: until it is inside, or until it stands where it is ``fast``; 0: it is not late.
        drawn_to: the limit to use until then, in the least time; a position, measured outward.
        apart: a distance of both position limits that lets ``JerkLaw`` use the whole acceleration
            limit.
        gaps: from the new limit to where the joint can come to rest, 0 where it is not late.
    """

    fast: NDArray[np.bool_]
    ticks: NDArray[np.int64]
    drawn_to: Vector
    apart: Vector
    gaps: Vector

    @classmethod
    def of(cls, old: JointLimits, new: JointLimits, motion: Motion) -> LimitTiming:
        """Return the timing of a change of limits at this state of motion."""
        n, dt = new.n, motion.dt
        # Both sides in one vector, each measured outward: the lower side is mirrored. Everything
        # below then reads as for an upper limit: outside is position > end, outward is speed > 0.
        position = np.concatenate((-motion.position, motion.position))
        speed = np.concatenate((-motion.applied, motion.applied))
        outward, jerk, larger = _accelerations(old, new, motion)
        ends = np.concatenate((-new.positions[:n], new.positions[n:]))
        inside = ends - position >= -_KEPT
        # Late: outside the limit, or not able to stop in front of it with the new acceleration. Of
        # the two jerk limits the larger one counts here: a joint that brakes keeps it (``_eased``).
        either = replace(new, jerk=np.maximum(old.jerk, new.jerk))
        late = ~can_stop(motion.position, either, dt, motion.applied, motion.acceleration)
        # Keeping the old acceleration until the joint stands helps only where it was larger. Any
        # other late joint is brought back inside with the new acceleration.
        fast = inside & late & (old.rates > new.rates)
        # Outside one limit and too fast for the other one: it moves inward by itself, and only the
        # side in front of it stays late. ``np.roll`` by n swaps the two sides. ``fast`` is not
        # affected: it needs ``inside``.
        late &= inside | ~np.roll(late, n)
        rate, jerk = np.where(fast, old.rates, new.rates), np.where(fast, larger, jerk)
        time = np.where(
            fast,
            _time_to_stand(speed, outward, rate, jerk),
            _time_to_cross(ends - position, speed, outward, rate, jerk, new.speeds),
        )
        # Rounded up: see the module. _KEPT keeps a time that is a whole number of ticks, but for
        # rounding, from costing one tick more.
        ticks = np.where(late, np.ceil(time / dt - _KEPT), 0.0).astype(np.int64)
        # With W the distance of the limits, ``JerkLaw`` uses at most S cbrt(1/8 + W / (dt S)). That
        # is at least A = a dt if W >= a^3 / j^2, with S = j dt^2. ``behind`` is the other limit,
        # measured outward on this side.
        apart, behind = rate**3 / jerk**2, -np.roll(ends, n)
        # The limit that leaves one choice, full acceleration inward: it lies inside both the new
        # limit and the joint by the room d of u(d) = v_max, that is d = v_max (v_max / (2 a) + dt).
        # Until the joint has crossed the new limit, u towards ``drawn_to`` is at most -v_max.
        drawn_to = np.minimum(ends, position) - new.speeds * (new.speeds / (2.0 * rate) + dt)
        # But a joint must not be driven through its other limit: the drawn limit keeps ``apart``
        # from it, or stays at the new limit where both are closer than that. A ``fast`` joint only
        # brakes, and does not come to the other limit: there ``_drawn`` moves that one instead.
        drawn_to = np.where(fast, drawn_to, np.maximum(drawn_to, np.minimum(behind + apart, ends)))
        # Where a joint that moves outward comes to rest: one tick at its speed, then v^2 / (2 a).
        away = np.maximum(speed, 0.0)
        rest = position + away * (away / (2.0 * rate) + dt)
        gaps = np.where(late, np.maximum(rest - ends, 0.0), 0.0)
        return cls(fast, ticks, drawn_to, apart, gaps)


def _accelerations(
    old: JointLimits, new: JointLimits, motion: Motion
) -> tuple[Vector, Vector, Vector]:
    """Return the acceleration outward, the new jerk limit and the larger one, shape (2n,) each.

    Where jerk is not limited, a finite jerk stands for it: 1e10 a / dt, with which the ramp to the
    full acceleration takes 1e-10 ticks.
    """
    endless = 1e10 * new.rates / motion.dt
    if motion.acceleration is None:
        return np.zeros(2 * new.n), endless, endless
    return (
        np.concatenate((-motion.acceleration, motion.acceleration)),
        np.minimum(np.tile(new.jerk, 2), endless),
        np.minimum(np.tile(np.maximum(old.jerk, new.jerk), 2), endless),
    )


def _time_to_cross(
    room: Vector, speed: Vector, outward: Vector, rate: Vector, jerk: Vector, fastest: Vector
) -> Vector:
    """Return when a joint that accelerates inward with ``rate`` has crossed its limit, (2n,) [s].

    Where it stops before that limit, the time until it stands.
    """
    # r^2 = v^2 + 2 a e with e = -room: r is the speed at the crossing. r^2 < 0 means that the joint
    # stops in front of the limit; with r = 0 the time is v / a, until it stands.
    root = np.sqrt(np.maximum(speed * speed - 2.0 * rate * room, 0.0))
    capped = np.minimum(root, fastest)
    time: Vector = (root * root - capped * capped) / (2.0 * rate * fastest)
    time += (speed + capped) / rate
    # The ramp to the full acceleration costs at most twice the velocity gained in it, and at the
    # velocity limit the acceleration fades as slowly as it came.
    time += (2.0 * np.maximum(rate + outward, 0.0) ** 2 / rate + rate) / jerk
    return time


def _time_to_stand(speed: Vector, outward: Vector, rate: Vector, jerk: Vector) -> Vector:
    """Return when a joint stands that has the acceleration ``outward`` and brakes, (2n,) [s]."""
    # The acceleration falls from ``outward`` to -rate with the full jerk. If the joint stands
    # during this ramp, at v + outward t - jerk t^2 / 2 = 0, that t is ``early``.
    ramp = np.maximum(rate + outward, 0.0) / jerk
    early = (outward + np.sqrt(np.maximum(outward * outward + 2.0 * jerk * speed, 0.0))) / jerk
    # Otherwise the rest is braked with ``rate``: after the ramp R the speed is
    # v + outward R - jerk R^2 / 2 = v + jerk R^2 / 2 - rate R, and R + that / rate is the time.
    return np.where(early <= ramp, early, (speed + 0.5 * jerk * ramp * ramp) / rate)
