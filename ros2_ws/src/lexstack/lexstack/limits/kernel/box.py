"""The bounds on chi of one tick, in loops over the joints: the equations of ``viable_bounds``.

Every line stands for one line there, in the same order of operations: the bits are the same.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lexstack.compiled import compiled, entry
from lexstack.limits.kernel.braking import stoppable_change
from lexstack.types import Matrix, Vector

_GIVEN = "Array(float64, 1, 'A', readonly=True)"
_TABLE = "Array(float64, 2, 'C', readonly=True)"


@compiled
def check(limits: Matrix, one: Vector, other: Vector, third: Vector) -> None:
    """Raise ValueError for vectors that are not as long as the limits."""
    if not one.size == other.size == third.size == limits.shape[1]:
        raise ValueError("box: the arrays do not fit each other")


@compiled
def larger(one: float, other: float) -> float:
    """Return the larger number, NaN where one of them is none, as ``np.maximum`` does."""
    return one if one >= other or one != one else other  # noqa: PLR0124


@compiled
def smaller(one: float, other: float) -> float:
    """Return the smaller number, NaN where one of them is none, as ``np.minimum`` does."""
    return one if one <= other or one != one else other  # noqa: PLR0124


@compiled
def approach(room: float, rate: float, dt: float) -> float:
    """Return u(d), the speed from which ``rate`` still stops within a room: ``approach_speed``."""
    reach, doubled = rate * dt, rate * room
    doubled += doubled
    return doubled / (math.sqrt(abs(doubled) + reach * reach) + reach)


@compiled
def without_acceleration(limits: Matrix, j: int, position: float, dt: float) -> tuple[float, float]:
    """Return L and U of joint j: how fast it may move towards either position limit."""
    fastest, rate = limits[2, j], limits[3, j]
    lower = approach(limits[0, j] - position, rate, dt)
    upper = approach(limits[1, j] - position, rate, dt)
    return (
        larger(smaller(lower, fastest), -fastest),
        larger(smaller(upper, fastest), -fastest),
    )


@compiled
def common(lower: float, upper: float, sent: float, reach: float) -> tuple[float, float]:
    """Return an interval cut with what is within reach of ``sent``; itself, where that is empty."""
    lowest, highest = larger(lower, sent - reach), smaller(upper, sent + reach)
    return (lower, upper) if lowest > highest else (lowest, highest)


@compiled
def without_jerk(
    limits: Matrix, j: int, position: float, dt: float, applied: float, sent: float
) -> tuple[float, float]:
    """Return the interval of joint j by its position, velocity and acceleration limits."""
    lower, upper = without_acceleration(limits, j, position, dt)
    reach = limits[3, j] * dt
    lowest, highest = common(applied - reach, applied + reach, sent, reach)
    return (
        smaller(larger(lower, lowest), highest),
        smaller(larger(upper, lowest), highest),
    )


@entry(f"void({_GIVEN}, {_TABLE}, float64, float64[:, ::1])")
def target(position: Vector, limits: Matrix, dt: float, box: Matrix) -> None:
    """Set the box of a target, which needs no acceleration limit: ``target_bounds``.

    Args:
        position: q*, shape (n,).
        limits: ``JointLimits.table``, shape (4, n).
        dt: control period [s].
        box: L and U, shape (2, n).
    """
    check(limits, position, position, position)
    for j in range(position.size):
        box[0, j], box[1, j] = without_acceleration(limits, j, position[j], dt)


@entry(f"void({_GIVEN}, {_TABLE}, float64, {_GIVEN}, {_GIVEN}, float64[:, ::1])")
def command(
    position: Vector, limits: Matrix, dt: float, applied: Vector, sent: Vector, box: Matrix
) -> None:
    """Set the box of a command: ``viable_bounds`` without jerk limits.

    Args:
        position: q*, shape (n,).
        limits: ``JointLimits.table``, shape (4, n).
        dt: control period [s].
        applied: the velocity that the plant applied last, shape (n,).
        sent: the one that was sent last, or ``applied`` again, shape (n,).
        box: lower and upper end, shape (2, n).
    """
    check(limits, position, applied, sent)
    for j in range(position.size):
        box[0, j], box[1, j] = without_jerk(limits, j, position[j], dt, applied[j], sent[j])


@compiled
def most_distance(speed: float, change: float, used: float, step: float) -> float:
    """Return the upper bound of F(v, w') of ``JerkLaw``: cheap, and enough far from the limits."""
    distance = speed + change
    c = larger(change - 0.5 * step, 0.0)
    gained = c * c / (2.0 * step)
    z = larger(distance, 0.0) + gained
    distance += gained
    c += 0.5 * used
    c /= step
    c += z / (2.0 * used)
    return distance + c * z


@compiled
def within_velocity(
    law: Matrix, at: int, room: float, speed: float, change: float
) -> tuple[float, float]:
    """Return the largest change towards a limit by acceleration and jerk, then by velocity too.

    The second one is before ``larger(_, least)``: the hardest braking is known from both sides.
    """
    fastest, most, used, step = law[1, at], law[2, at], law[3, at], law[4, at]
    largest = smaller(larger(used, change - step), change + step)
    largest = smaller(larger(largest, -most), most)
    ceiling = fastest
    if not room >= 0.0:  # outside: back, at least at the speed that stops at the limit
        ceiling = larger(approach(room, used, 1.0), -fastest)
    return largest, smaller(largest, approach(ceiling - speed, step, 1.0))


@compiled
def keeping_room(
    law: Matrix, at: int, room: float, speed: float, least: float, largest: float
) -> float:
    """Return the largest change towards a limit after which the joint can stop in front of it."""
    used, step = law[3, at], law[4, at]
    room = larger(room, 0.0)
    if not most_distance(speed, largest, used, step) > room:
        return largest
    numbers = (room / step, speed / step, used / step, least / step, largest / step)
    return float(step * stoppable_change(*numbers))


@entry(
    f"void({_GIVEN}, {_TABLE}, {_TABLE}, Array(boolean, 1, 'C', readonly=True), float64, "
    f"{_GIVEN}, {_GIVEN}, boolean, {_GIVEN}, float64[:, ::1])"
)
def with_jerk(
    position: Vector,
    limits: Matrix,
    law: Matrix,
    free: NDArray[np.bool_],
    dt: float,
    applied: Vector,
    sent: Vector,
    other: bool,
    acceleration: Vector,
    box: Matrix,
) -> None:
    """Set the box of a command: ``viable_bounds`` with jerk limits, ``JerkLaw.changes``.

    Args:
        position: q*, shape (n,).
        limits: ``JointLimits.table``, shape (4, n).
        law: ``JerkLaw.table``, shape (5, 2 n).
        free: which joints have no jerk limit, shape (n,).
        dt: control period [s].
        applied: the velocity that the plant applied last, shape (n,).
        sent: the one that was sent last, or ``applied`` again, shape (n,).
        other: whether ``sent`` is another one than ``applied``.
        acceleration: of the last tick, shape (n,).
        box: lower and upper end, shape (2, n).
    """
    check(limits, position, applied, sent)
    check(limits, position, applied, acceleration)
    n = position.size
    for j in range(n):
        q, v = position[j], applied[j]
        if free[j]:
            box[0, j], box[1, j] = without_jerk(limits, j, q, dt, v, sent[j])
            continue
        change = acceleration[j] * dt
        below, above = law[0, j] - -q / dt, law[0, n + j] - q / dt
        down, slow = within_velocity(law, j, below, -v, -change)
        up, fast = within_velocity(law, n + j, above, v, change)
        # The least change towards one limit is the largest one towards the other.
        slow, fast = larger(slow, -up), larger(fast, -down)
        least = -keeping_room(law, j, below, -v, -fast, slow)
        largest = keeping_room(law, n + j, above, v, -slow, fast)
        if least > largest:  # by rounding, or where the state is not viable
            least = largest = 0.5 * (least + largest)
        least, largest = least + v, largest + v
        if other:
            least, largest = common(least, largest, sent[j], limits[3, j] * dt)
        box[0, j], box[1, j] = least, largest
