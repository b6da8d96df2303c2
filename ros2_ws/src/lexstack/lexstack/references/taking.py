"""One target taken into a decision: how the reference gets from where it is to the target."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar, cast

import numpy as np

from lexstack.references.base_twist import BaseTwist, BaseTwistStream
from lexstack.references.set_point import SetPoint, held, led, led_onto, settled
from lexstack.references.spaces import BASES, JOINTS, POSES, Space
from lexstack.references.timeline import Setting
from lexstack.references.trajectory import Trajectory
from lexstack.references.twist_stream import Twist, TwistStream
from lexstack.references.values import TOOL, Hold, Target
from lexstack.robots import Pose
from lexstack.types import Vector

T = TypeVar("T")

_HELD = 0.5  # s, of the way to rest where set-points are not led in


def taken(setting: Setting, target: Target, stamp: float, lead_in: float) -> Setting:
    """Return a decision with one target put in; the very same one where it says nothing new.

    Args:
        setting: the decision until now.
        target: that takes effect.
        stamp: time of the tick [s].
        lead_in: time in which the reference moves to the target [s].
    """
    i = target.robot
    if target.ee is not None:
        return _with_frame(setting, target, stamp, lead_in)
    if target.base is not None:
        point: Trajectory[Vector] | None
        if isinstance(target.base, BaseTwist):
            point = BaseTwistStream.begun(setting.base[i], stamp, target.base)
        else:
            point = _next(setting.base[i], target, _same, _Way(stamp, lead_in, BASES))
        if point is setting.base[i] or point is None:
            return setting
        return replace(setting, base=(*setting.base[:i], point, *setting.base[i + 1 :]))
    if target.posture is None:
        return setting
    before = setting.postures.get(i)
    point = _next(before, target, _same, _Way(stamp, lead_in, JOINTS))
    if point is before or point is None:
        return setting
    return replace(setting, postures={**setting.postures, i: point})


def _with_frame(setting: Setting, target: Target, stamp: float, lead_in: float) -> Setting:
    """Return a decision with the target of a frame put in."""
    i, key = target.robot, (target.robot, target.frame)
    before = setting.ee[i] if target.frame == TOOL else setting.frames.get(key)
    point: Trajectory[Pose] | None
    if isinstance(target.ee, Twist):
        begin = SetPoint(target.begin) if isinstance(target.begin, Pose) else None
        start = begin if before is None else before
        if start is None:
            return setting  # the schedule takes no such target
        point = TwistStream.begun(start, stamp, target.ee)
    else:
        point = _next(before, target, _same_pose, _Way(stamp, lead_in, POSES))
    if point is before or point is None:
        return setting
    if target.frame == TOOL:
        return replace(setting, ee=(*setting.ee[:i], point, *setting.ee[i + 1 :]))
    return replace(setting, frames={**setting.frames, key: point})


@dataclass(frozen=True, slots=True)
class _Way(Generic[T]):
    """Time of the tick [s], time in which a reference moves to a target [s], kind of its values."""

    stamp: float
    lead_in: float
    space: Space[T]


def _next(
    before: Trajectory[T] | None, target: Target, same: Callable[[Any, Any], bool], way: _Way[T]
) -> Trajectory[T] | None:
    """Return the reference from now on: the one before, if the goal is its own.

    Args:
        before: the reference until now; None: there is none, and the new one begins at its goal,
            or where the target says.
        target: whose goal is a value, a trajectory, or ``Hold``.
        same: whether two values are equal in every bit.
        way: how it gets there.
    """
    goal: Any = next(g for g in (target.ee, target.base, target.posture) if g is not None)
    stamp, space = way.stamp, way.space
    if before is None and target.begin is not None:
        before = SetPoint(cast("T", target.begin), space=space)
    if isinstance(goal, Hold):
        if before is None or settled(before, stamp):
            return before
        return held(before, stamp, way.lead_in or _HELD, space)
    if before is None:
        return goal if hasattr(goal, "rate") else SetPoint(goal, space=space)
    if hasattr(goal, "rate"):
        return led_onto(before, goal, stamp, max(way.lead_in, target.duration or 0.0), space)
    if isinstance(before, SetPoint) and same(before.goal, goal):
        return before
    own = target.duration is not None
    duration = way.lead_in if target.duration is None else target.duration
    return led(before, goal, stamp, duration, space, fed=own)


def _same(one: Vector, other: Vector) -> bool:
    """Return whether two vectors are equal in every bit."""
    return np.array_equal(one, other)


def _same_pose(one: Pose, other: Pose) -> bool:
    """Return whether two poses are equal in every bit."""
    return _same(one.position, other.position) and _same(one.rotation, other.rotation)
