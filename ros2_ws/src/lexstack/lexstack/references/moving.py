"""References that are more than the set-point of a tool or a base, as plain numbers.

What ``References.msg`` calls a ``Trajectory``: ``kind`` says what ``values`` are, and ``lead`` is
what is left of the way to it, as of a set-point. A pose is x, y, z, then its rotation row by row.

    set_point         the goal
    fed               the goal of a set-point whose velocity on the way is added
    waypoints         time, pose; of each point
    waypoints_twists  time, pose, twist; of each point
    spline            time, value; of each point
    spline_rates      time, value, rate; of each point
    twist             twist, timeout, linear, angular; of its ramp start, pose, twist, duration
    base_twist        velocity, whether in the axes of the base, timeout, linear, angular; of its
                      ramp start, place, velocity before, duration
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.references.base_twist import BaseRamp, BaseTwist, BaseTwistStream
from lexstack.references.fading import Fading
from lexstack.references.set_point import Led, SetPoint
from lexstack.references.spaces import BASES, JOINTS, POSES
from lexstack.references.spline import Spline
from lexstack.references.trajectory import Trajectory
from lexstack.references.twist_stream import Ramp, Twist, TwistStream
from lexstack.references.values import TOOL
from lexstack.references.waypoints import Waypoints
from lexstack.robots import Pose
from lexstack.types import Matrix, Vector

EE, BASE, POSTURE = "ee", "base", "posture"
_MOST_POINTS = 10_000  # of a trajectory that is sent
_POSE = 12
_NONE = np.zeros(0)
_SQUARE = 1e-6  # how far R^T R may be from the unit matrix
_HUGE = 1e6  # m, rad, s
_SPACES = {EE: POSES, BASE: BASES, POSTURE: JOINTS}


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """One reference in numbers.

    Attributes:
        robot: its place in the team.
        of: ``EE``, ``BASE`` or ``POSTURE``.
        kind: what ``values`` are.
        values: see above.
        lead: start [s], duration [s], then gap, rate and curvature; empty: there is no way left.
        frame: of ``EE``.
    """

    robot: int
    of: str
    kind: str
    values: Vector
    lead: Vector = field(default_factory=lambda: _NONE)
    frame: str = TOOL

    def same(self, other: Moving) -> bool:
        """Return whether another one is the same reference, bit by bit."""
        alike = (self.robot, self.of, self.kind, self.frame)
        return (
            alike == (other.robot, other.of, other.kind, other.frame)
            and np.array_equal(self.values, other.values)
            and np.array_equal(self.lead, other.lead)
        )


def moving_of(point: Trajectory[Any], robot: int, of: str, frame: str = TOOL) -> Moving:
    """Return a reference in numbers; raises InputError for one of a user's own."""
    goal, fading = point, None
    if isinstance(point, Led):
        goal, fading = point.goal, point.fading
    if isinstance(point, SetPoint):
        kind = "fed" if point.fed else "set_point"
        return Moving(robot, of, kind, _row(point.goal), lead_of(point.fading), frame)
    kind, values = _numbers(goal)
    return Moving(robot, of, kind, values, lead_of(fading), frame)


def lead_of(fading: Fading | None) -> Vector:
    """Return start, duration, gap, rate and curvature in one row; of no way an empty one."""
    if fading is None:
        return _NONE
    head = (fading.start, fading.duration)
    return np.concatenate((head, fading.gap, fading.rate, fading.curvature))


def trajectory_of(moving: Moving, size: int, where: str) -> Trajectory[Any]:
    """Return the reference, equal in every bit to the one that was put into numbers.

    Args:
        moving: the numbers.
        size: of a value: 3 of a base, of a posture the arm's joints; not of a pose.
        where: for errors.

    Raises:
        InputError: numbers that make none.
    """
    gap = 6 if moving.of == EE else size
    lead = np.array(moving.lead, dtype=np.float64)
    if lead.shape not in ((0,), (2 + 3 * gap,)) or not np.isfinite(lead).all():
        raise InputError(f"{where}: lead: expected {2 + 3 * gap} finite numbers, or none")
    values = np.array(moving.values, dtype=np.float64)
    if values.ndim != 1 or not values.size or not (np.abs(values) <= _HUGE).all():
        raise InputError(f"{where}: values: expected finite numbers, at most {_HUGE:g}")
    read = _READ.get((moving.of == EE, moving.kind))
    if read is None:
        raise InputError(f"{where}: kind: {shown(moving.kind)} is no kind of {moving.of}")
    try:
        goal = _kept(read, values.tobytes(), size)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
    return _with_lead(goal, lead, moving)


def _with_lead(goal: Any, lead: Vector, moving: Moving) -> Trajectory[Any]:
    """Return a goal with the way that is left to it."""
    fading = fading_of(lead) if lead.size and lead[1] > 0.0 else None
    space: Any = _SPACES[moving.of]
    if moving.kind in ("set_point", "fed"):
        return SetPoint(goal, fading, space, moving.kind == "fed")
    return goal if fading is None else Led(goal, fading, space)


def fading_of(lead: Vector) -> Fading:
    """Return the way in a row that ``lead_of`` made."""
    gap, rate, curvature = lead[2:].reshape(3, -1)
    return Fading(float(lead[0]), float(lead[1]), gap, rate, curvature)


# ---- out


def _numbers(goal: Trajectory[Any]) -> tuple[str, Vector]:
    """Return the kind of a trajectory and its values."""
    if isinstance(goal, Waypoints):
        poses = np.array([_row(pose) for pose in goal.poses])
        return _table("waypoints", "waypoints_twists", goal.times, poses, goal.twists)
    if isinstance(goal, Spline):
        return _table("spline", "spline_rates", goal.times, goal.values, goal.rates)
    if isinstance(goal, TwistStream):
        twist, ramp = goal.twist, goal.follow
        limits = [twist.timeout, twist.linear, twist.angular, ramp.start]
        parts = (twist.value, limits, _row(ramp.pose), ramp.before, [ramp.duration])
        return "twist", np.concatenate(parts)
    if isinstance(goal, BaseTwistStream):
        drive, way = goal.twist, goal.follow
        limits = [float(drive.turning), drive.timeout, drive.linear, drive.angular, way.start]
        return "base_twist", np.concatenate(
            (drive.value, limits, way.place, way.before, [way.duration])
        )
    raise InputError(f"references: a {type(goal).__name__} is not sent: it is of no known kind")


def _table(
    plain: str, rated: str, times: Vector, values: Matrix, rates: Matrix | None
) -> tuple[str, Vector]:
    """Return points one after another."""
    columns = [times[:, None], values, *([] if rates is None else [rates])]
    return plain if rates is None else rated, np.hstack(columns).ravel()


def _row(value: Pose | Vector) -> Vector:
    """Return a pose or a vector as one row."""
    if isinstance(value, Pose):
        return np.concatenate((value.position, value.rotation.reshape(9)))
    return np.asarray(value)


# ---- in


@lru_cache(maxsize=64)  # every decision carries all of them: each is worked out once
def _kept(read: Callable[[Vector, int], Any], values: bytes, size: int) -> Any:
    """Return the goal that numbers describe."""
    return read(np.frombuffer(values), size)


def pose_of(row: Vector) -> Pose:
    """Return the pose in a row of 12 numbers; raises InputError for what is no rotation."""
    rotation = row[3:12].reshape(3, 3)
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > _SQUARE:
        raise InputError("its last nine values are no rotation matrix")
    return Pose(row[:3], rotation)


def _points(values: Vector, width: int) -> Matrix:
    """Return values as points, shape (N, width)."""
    if values.size % width or values.size > width * _MOST_POINTS:
        raise InputError(f"values: expected {width} for each of at most {_MOST_POINTS} points")
    return values.reshape(-1, width)


def _exactly(values: Vector, count: int) -> Vector:
    """Return values that are as many as they must be."""
    if values.size != count:
        raise InputError(f"values: expected {count}, got {values.size}")
    return values


def _waypoints(values: Vector, _size: int) -> Waypoints:
    """Return the way through poses at times."""
    rows = _points(values, 1 + _POSE)
    return Waypoints(rows[:, 0], tuple(_poses(rows)))


def _waypoints_twists(values: Vector, _size: int) -> Waypoints:
    """Return the way through poses with twists."""
    rows = _points(values, 7 + _POSE)
    return Waypoints(rows[:, 0], tuple(_poses(rows)), rows[:, 1 + _POSE :])


def _poses(rows: Matrix) -> Iterator[Pose]:
    """Yield the poses behind the times."""
    for row in rows:
        yield pose_of(row[1 : 1 + _POSE])


def _spline(values: Vector, size: int) -> Spline:
    """Return the spline through values at times."""
    rows = _points(values, 1 + size)
    return Spline(rows[:, 0], rows[:, 1:])


def _spline_rates(values: Vector, size: int) -> Spline:
    """Return the spline through values with rates."""
    rows = _points(values, 1 + 2 * size)
    return Spline(rows[:, 0], rows[:, 1 : 1 + size], rows[:, 1 + size :])


def _twist(values: Vector, _size: int) -> TwistStream:
    """Return the stream with its ramp."""
    head, rest = np.split(_exactly(values, 29), [9])
    twist = Twist(head[:6], *(float(value) for value in head[6:]))
    start, pose, before, duration = float(rest[0]), rest[1:13], rest[13:19], float(rest[19])
    if duration <= 0.0:
        raise InputError("values: the ramp of a twist must last")
    return TwistStream.along(Ramp(start, pose_of(pose), before, twist.value, duration), twist)


def _base_twist(values: Vector, size: int) -> BaseTwistStream:
    """Return the stream of a base with its ramp."""
    if size != len(_exactly(values, 15)[:3]):
        raise InputError("values: only a base has such a twist")
    turning, timeout, linear, angular, start = (float(value) for value in values[3:8])
    twist = BaseTwist(values[:3], bool(turning), timeout, linear, angular)
    duration = float(values[14])
    if duration <= 0.0:
        raise InputError("values: the ramp of a twist must last")
    ramp = BaseRamp(start, values[8:11], values[11:14], twist.value, duration, twist.turning)
    return BaseTwistStream.along(ramp, twist)


def _pose_goal(values: Vector, _size: int) -> Pose:
    """Return the pose."""
    return pose_of(_exactly(values, _POSE))


_READ: dict[tuple[bool, str], Callable[[Vector, int], Any]] = {
    (True, "set_point"): _pose_goal,
    (True, "fed"): _pose_goal,
    (True, "waypoints"): _waypoints,
    (True, "waypoints_twists"): _waypoints_twists,
    (True, "twist"): _twist,
    (False, "set_point"): _exactly,
    (False, "fed"): _exactly,
    (False, "spline"): _spline,
    (False, "spline_rates"): _spline_rates,
    (False, "base_twist"): _base_twist,
}
