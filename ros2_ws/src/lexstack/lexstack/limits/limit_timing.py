"""Which joints cannot keep new limits at once, and for how long.

With e the way from a limit out to the joint, v its velocity outward and r^2 = v^2 + 2 a e, a joint
that accelerates inward with a, up to its velocity limit, has crossed the limit after

    t = (v + r) / a  where r <= v_max,  else  (v + v_max) / a + (r^2 - v_max^2) / (2 a v_max)

In steps of dt it moves ahead of that, so the next tick is soon enough.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lexstack.limits.joint_limits import JointLimits
from lexstack.limits.viable_bounds import can_stop
from lexstack.types import Vector

_KEPT = 1e-9  # m, rad, m/s, rad/s: a limit exceeded by no more is kept


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """What ``viable_bounds`` is told of the joints at one tick.

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
    """How late the joints are, shape (2n,): as seen towards the lower, then the upper limits.

    Attributes:
        fast: whether it is in front of the limit, but too fast to stop with the new acceleration.
        ticks: until it is inside, or stands where it is fast; 0 where it is not late.
        drawn_to: the limit until then, in the least time.
        apart: how far the other limit must be from it, for ``jerk`` to use all acceleration.
        gaps: from the new limit to where the joint can come to rest, 0 where it is not late.
    """

    fast: NDArray[np.bool_]
    ticks: NDArray[np.int64]
    drawn_to: Vector
    apart: Vector
    gaps: Vector

    @classmethod
    def of(cls, old: JointLimits, new: JointLimits, motion: Motion) -> LimitTiming:
        """Return it for a change of limits at this state of motion."""
        n, dt = new.n, motion.dt
        position = np.concatenate((-motion.position, motion.position))
        speed = np.concatenate((-motion.applied, motion.applied))
        outward, jerk, larger = _accelerations(old, new, motion)
        walls = np.concatenate((-new.walls[:n], new.walls[n:]))
        inside = walls - position >= -_KEPT
        either = replace(new, jerk=np.maximum(old.jerk, new.jerk))
        late = ~can_stop(motion.position, either, dt, motion.applied, motion.acceleration)
        fast = inside & late & (old.rates > new.rates)
        # Outside one limit and too fast for the other one: it comes inside by itself.
        late &= inside | ~np.roll(late, n)
        rate, jerk = np.where(fast, old.rates, new.rates), np.where(fast, larger, jerk)
        time = np.where(
            fast,
            _time_to_stand(speed, outward, rate, jerk),
            _time_to_cross(walls - position, speed, outward, rate, jerk, new.speeds),
        )
        ticks = np.where(late, np.ceil(time / dt - _KEPT), 0.0).astype(np.int64)
        apart, behind = rate**3 / jerk**2, -np.roll(walls, n)
        drawn_to = np.minimum(walls, position) - new.speeds * (new.speeds / (2.0 * rate) + dt)
        drawn_to = np.where(fast, drawn_to, np.maximum(drawn_to, np.minimum(behind + apart, walls)))
        away = np.maximum(speed, 0.0)
        rest = position + away * (away / (2.0 * rate) + dt)
        gaps = np.where(late, np.maximum(rest - walls, 0.0), 0.0)
        return cls(fast, ticks, drawn_to, apart, gaps)


def _accelerations(
    old: JointLimits, new: JointLimits, motion: Motion
) -> tuple[Vector, Vector, Vector]:
    """Return the acceleration outward, the new jerk limit and the larger one, shape (2n,) each.

    Where jerk is not limited, as much of it as is as good as that.
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

    Where it stops before that limit, when it stands.
    """
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
    ramp = np.maximum(rate + outward, 0.0) / jerk
    early = (outward + np.sqrt(np.maximum(outward * outward + 2.0 * jerk * speed, 0.0))) / jerk
    return np.where(early <= ramp, early, (speed + 0.5 * jerk * ramp * ramp) / rate)
