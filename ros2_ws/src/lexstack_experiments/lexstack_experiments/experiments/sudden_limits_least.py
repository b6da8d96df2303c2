"""The least time in which joints can be inside new limits: what no controller can beat.

Worked out apart from ``lexstack.limits.limit_transition``. In discrete time, q(k+1) = q(k) + dt
v(k+1), a joint that is outside after k ticks whatever it does needs k + 1 of them. It is nearest
to its limit, or furthest inside, if it accelerates inward with all it has, up to its velocity
limit; with jerk limits it does what a linear program says.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from lexstack.limits import JointLimits, Motion

KEPT = 1e-9  # m, rad: outside by no more is inside
_MOST = 1000  # ticks


def least_ticks(motion: Motion, limits: JointLimits) -> NDArray[np.int64]:
    """Return after how many ticks each joint can be inside at the soonest, shape (n,).

    0 where it can stay inside. Jerk counts where ``motion`` has an acceleration, and then only for
    joints that are outside at the beginning.
    """
    count = np.zeros(limits.n, dtype=np.int64)
    for sign, wall in ((1.0, limits.position_upper), (-1.0, limits.position_lower)):
        for joint in np.flatnonzero(np.isfinite(wall)):
            out = sign * (motion.position[joint] - wall[joint])
            rates = (limits.velocity[joint], limits.acceleration[joint] * motion.dt)
            speed = sign * motion.applied[joint]
            ticks = _without_jerk(out / motion.dt, speed, *rates, KEPT / motion.dt)
            if motion.acceleration is not None and out > KEPT:
                last = sign * motion.acceleration[joint] * motion.dt
                step = limits.jerk[joint] * motion.dt**2
                while _nearest(ticks, speed, last, rates, step) > (KEPT - out) / motion.dt:
                    ticks += 1
            count[joint] = max(count[joint], ticks)
    return count


def _without_jerk(out: float, speed: float, fastest: float, reach: float, kept: float) -> int:
    """Return the ticks of one joint, ``out`` beyond its limit and going outward with ``speed``."""
    last = 0 if out > kept else -1
    for tick in range(1, _MOST):
        speed = min(max(-fastest, speed - reach), speed + reach)
        out += speed
        if out > kept:
            last = tick
        elif speed <= 0.0:
            break
    return last + 1


def _nearest(
    ticks: int, speed: float, last: float, rates: tuple[float, float], step: float
) -> float:
    """Return the least sum of the next speeds: how far out a joint goes, in units of dt.

    Args:
        ticks: how many.
        speed: before them, outward.
        last: its change in the tick before.
        rates: the largest speed, and the largest change of it in a tick.
        step: the largest change of that.
    """
    fastest, reach = rates
    adds = np.tril(np.ones((ticks, ticks)))  # from changes to speeds
    turns = np.eye(ticks) - np.eye(ticks, k=-1)
    before = np.zeros(ticks)
    before[0] = last
    found = linprog(
        adds.sum(axis=0),
        A_ub=np.vstack([-adds, turns, -turns]),
        b_ub=np.concatenate([np.full(ticks, fastest + speed), step + before, step - before]),
        bounds=(-reach, reach),
        method="highs",
    )
    return np.inf if found.fun is None else float(found.fun + ticks * speed)
