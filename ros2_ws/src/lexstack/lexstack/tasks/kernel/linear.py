"""What tasks ask for that are linear in the joints: base pose and posture, T(22) to T(30)."""

from __future__ import annotations

import math

from lexstack.compiled import entry
from lexstack.types import Vector

_TURN = 2.0 * math.pi  # rad
_VECTOR = "Array(float64, 1, 'A', readonly=True)"


@entry(f"void({_VECTOR}, {_VECTOR}, int64, float64, int64, float64[::1])")
def towards(
    goal: Vector, position: Vector, start: int, gain: float, yaw: int, target: Vector
) -> None:
    """Set gain (goal - position), with one angle of it in (-pi, pi].

    Args:
        goal: shape (m,).
        position: of all robots.
        start: of the goal's entries in it.
        gain: lambda.
        yaw: which entry is that angle; -1: none.
        target: shape (m,).
    """
    if goal.size != target.size or start < 0 or start + goal.size > position.size:
        raise ValueError("towards: the arrays do not fit each other")
    for j in range(goal.size):
        error = goal[j] - position[start + j]
        if j == yaw:
            error %= _TURN
            if error > math.pi:
                error -= _TURN
        target[j] = gain * error
