"""One target taken into a decision: how the reference gets from where it is to the target."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from lexstack.references.set_point import SetPoint, led, led_onto
from lexstack.references.spaces import BASES, JOINTS, POSES, Space
from lexstack.references.timeline import Setting
from lexstack.references.trajectory import Trajectory
from lexstack.references.twist_stream import Twist, TwistStream
from lexstack.references.values import TOOL, Target
from lexstack.robots import Pose
from lexstack.types import Vector

T = TypeVar("T")


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
        point = _next(setting.base[i], target.base, _same, (stamp, lead_in, BASES))
        if point is setting.base[i]:
            return setting
        return replace(setting, base=(*setting.base[:i], point, *setting.base[i + 1 :]))
    if target.posture is None:
        return setting
    before = setting.postures.get(i)
    point = _next(before, target.posture, _same, (stamp, lead_in, JOINTS))
    if point is before:
        return setting
    return replace(setting, postures={**setting.postures, i: point})


def _with_frame(setting: Setting, target: Target, stamp: float, lead_in: float) -> Setting:
    """Return a decision with the target of a frame put in."""
    i, key = target.robot, (target.robot, target.frame)
    before = setting.ee[i] if target.frame == TOOL else setting.frames.get(key)
    point: Trajectory[Pose]
    if isinstance(target.ee, Twist):
        if before is None:
            return setting  # the schedule takes no such target
        point = TwistStream.begun(before, stamp, target.ee)
    else:
        point = _next(before, target.ee, _same_pose, (stamp, lead_in, POSES))
    if point is before:
        return setting
    if target.frame == TOOL:
        return replace(setting, ee=(*setting.ee[:i], point, *setting.ee[i + 1 :]))
    return replace(setting, frames={**setting.frames, key: point})


def _next(
    before: Trajectory[T] | None,
    goal: Any,
    same: Callable[[Any, Any], bool],
    way: tuple[float, float, Space[T]],
) -> Trajectory[T]:
    """Return the reference from now on: the one before, if the goal is its own.

    Args:
        before: the reference until now; None: there is none, and the new one begins at its goal.
        goal: a value or a trajectory.
        same: whether two values are equal in every bit.
        way: time of the tick [s], time of the way [s], and the kind of the values.
    """
    stamp, lead_in, space = way
    if hasattr(goal, "rate"):
        return goal if before is None else led_onto(before, goal, stamp, lead_in, space)
    if before is None:
        return SetPoint(goal, space=space)
    if isinstance(before, SetPoint) and same(before.goal, goal):
        return before
    return led(before, goal, stamp, lead_in, space)


def _same(one: Vector, other: Vector) -> bool:
    """Return whether two vectors are equal in every bit."""
    return np.array_equal(one, other)


def _same_pose(one: Pose, other: Pose) -> bool:
    """Return whether two poses are equal in every bit."""
    return _same(one.position, other.position) and _same(one.rotation, other.rotation)
