"""From decisions back to the targets that led to them: to decide on them again in another way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lexstack.errors import InputError
from lexstack.references.base_twist import BaseTwistStream
from lexstack.references.moving import BASE, EE, POSTURE, moving_of
from lexstack.references.set_point import Led, SetPoint
from lexstack.references.timeline import Setting
from lexstack.references.trajectory import Trajectory
from lexstack.references.twist_stream import TwistStream
from lexstack.references.values import TOOL, Target

_ROUNDING = 1e-6  # s, of times
Place = tuple[int, str, str]  # a robot, what of it, and the frame


def targets_between(before: Setting, after: Setting) -> Iterator[Target]:
    """Yield the targets that make the second of two decisions of the first one."""
    known = dict(_points(before))
    for place, point in _points(after):
        robot, of, frame = place
        old = known.get(place)
        if old is not None and _same(old, point, place):
            continue
        goal, duration = _goal(point)
        begin = point.at(after.at) if old is None and _begun(point) else None
        given: dict[str, Any] = {of: goal}
        yield Target(after.at, robot, **given, frame=frame, begin=begin, duration=duration)


def _points(setting: Setting) -> Iterator[tuple[Place, Trajectory[Any]]]:
    """Yield all references of a decision."""
    for robot, point in enumerate(setting.ee):
        yield (robot, EE, TOOL), point
    for (robot, frame), pose in setting.frames.items():
        yield (robot, EE, frame), pose
    for robot, place in enumerate(setting.base):
        yield (robot, BASE, TOOL), place
    for robot, posture in setting.postures.items():
        yield (robot, POSTURE, TOOL), posture


def _same(one: Trajectory[Any], other: Trajectory[Any], place: Place) -> bool:
    """Return whether two references are the same in every bit."""
    try:
        return one is other or moving_of(one, *place).same(moving_of(other, *place))
    except InputError:
        return False  # of a user's own kind


def _begun(point: Trajectory[Any]) -> bool:
    """Return whether a reference that there was not began elsewhere than at its goal."""
    way = isinstance(point, SetPoint) and point.fading is not None
    return way or isinstance(point, Led | TwistStream)


def _goal(point: Trajectory[Any]) -> tuple[Any, float | None]:
    """Return what was asked for, and the time for it where it was not the lead-in."""
    if isinstance(point, TwistStream | BaseTwistStream):
        return point.twist, None
    if isinstance(point, Led):
        fading, times = point.fading, getattr(point.goal, "times", None)
        whole = times is not None and abs(times[0] - fading.start - fading.duration) < _ROUNDING
        return point.goal, fading.duration if whole else None
    if isinstance(point, SetPoint):
        own = point.fed and point.fading is not None
        return point.goal, point.fading.duration if own and point.fading else None
    return point, None
