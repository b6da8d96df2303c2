"""What readers of targets share: the times, frames, poses and joints of a message's points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from trajectory_msgs.msg import MultiDOFJointTrajectory

from lexstack.errors import InputError, ModelError
from lexstack.options import shown
from lexstack.references import TOOL
from lexstack.robots import Pose, RobotModel, Team
from lexstack.types import Matrix, RobotState, Vector
from lexstack_config.reference_topics import ReferenceTopicsConfig
from lexstack_ros.messages.conversions import (
    Placing,
    placed,
    to_placement,
    to_seconds,
    to_vector,
)

Made = TypeVar("Made")

MOST_POINTS = 1000
"""Of a trajectory: its splines are found within a tick."""
_NEAREST = 1e-3  # s, between two points, at least
_FASTEST = 10.0  # m/s, rad/s: no robot is asked for more
_SHORTEST = 1e-6  # s: times are rounded


@dataclass(frozen=True, slots=True)
class Reading:
    """What a message of a target is read with.

    Attributes:
        team: the robots.
        robot: the place of the one that it is for.
        frame: the name of its frame that it is for.
        where: the topic, for errors.
        placing: finds the frame in which it is told.
        now: simulated time of the first tick at which it can take effect [s].
        options: what messages leave open.
        state: the newest of the plant; None: none has come.
    """

    team: Team
    robot: int
    frame: str
    where: str
    placing: Placing
    now: float
    options: ReferenceTopicsConfig
    state: RobotState | None

    @property
    def model(self) -> RobotModel:
        """The robot."""
        return self.team.robots[self.robot]

    def begin(self, frame: str) -> Pose | None:
        """Return where a frame is, if that is known; the tool has a reference always."""
        if self.state is None or frame == TOOL:
            return None
        q = self.state.q[self.team.q_slices[self.robot]]
        return self.model.at(q, self.model.frame(frame))[0]


# ---- times


def times_of(message: Any, stamp: float, reading: Reading) -> Vector:
    """Return the simulated times of a trajectory's points, shape (N,); none of an empty one."""
    where = reading.where
    check_few(message.points, f"{where}: points")
    if not message.points:
        return np.zeros(0)
    relative = np.array([to_seconds(point.time_from_start) for point in message.points])
    if relative[0] < 0.0:
        raise InputError(
            f"{where}: points[0]: time_from_start: must be >= 0, got {relative[0]:g} s"
        )
    check_order(relative, f"{where}: points")
    times = (stamp or reading.now) + relative
    if len(times) > 1:
        check_under_way(times, reading)
    return times


def duration_of(message: Any) -> float | None:
    """Return in which time the only point of a trajectory is to be reached; None: as any target."""
    return to_seconds(message.points[0].time_from_start) or None


def check_under_way(times: Vector, reading: Reading) -> None:
    """Raise InputError for a trajectory that is over already."""
    if times[-1] <= reading.now:
        raise InputError(
            f"{reading.where}: it ended at {times[-1]:.3f} s, simulated time is "
            f"{reading.now:.3f} s; stamp 0 means now"
        )


def first_or_now(times: Vector, now: float) -> float:
    """Return when a way by stamps takes effect: at its first one, or now."""
    return float(times[0]) if times[0] > now else 0.0


def until_first(times: Vector, stamp: float, now: float) -> float | None:
    """Return in which time the first point is to be reached [s]; None: there is none left."""
    left = float(times[0]) - max(stamp, now)
    return left if left > _SHORTEST else None


def check_order(times: Vector, where: str) -> None:
    """Raise InputError for times that do not increase."""
    for k, (one, other) in enumerate(pairwise(times.tolist()), start=1):
        if other - one < _NEAREST:
            raise InputError(
                f"{where}[{k}]: {other:g} s is not after {one:g} s, by {_NEAREST:g} s at least"
            )


def check_speeds(times: Vector, values: Matrix, where: str) -> None:
    """Raise InputError for points (N, m) that are too far apart for the time between them."""
    speeds = np.abs(np.diff(values, axis=0)).max(axis=1) / np.diff(times)
    k = int(np.argmax(speeds))
    if speeds[k] > _FASTEST:
        raise InputError(
            f"{where}[{k + 1}]: {speeds[k]:.3g} m/s or rad/s from the one before, "
            f"at most {_FASTEST:g}"
        )


def check_few(points: Sequence[Any], where: str) -> None:
    """Raise InputError for too many points."""
    if len(points) > MOST_POINTS:
        raise InputError(f"{where}: expected at most {MOST_POINTS}, got {len(points)}")


# ---- points


def frame_of(name: str, reading: Reading) -> str:
    """Return a frame of the robot by its name, with or without the robot's before it."""
    short = name.removeprefix(f"{reading.model.name}/")
    if short == TOOL:
        return short
    try:
        reading.model.frame(short)
    except ModelError as error:
        raise InputError(f"{reading.where}: joint_names: {error}") from error
    return short


def poses_of(
    message: MultiDOFJointTrajectory, k: int, count: int, origin: Pose | None, where: str
) -> tuple[list[Pose], Matrix | None]:
    """Return the poses of one frame in the world, and its twists if they are given."""
    poses, twists = [], room_for_rates(message, (len(message.points), 6), count, where)
    for i, point in enumerate(message.points):
        place = f"{where}: points[{i}]"
        if len(point.transforms) != count:
            raise InputError(f"{place}.transforms: expected {count}, got {len(point.transforms)}")
        transform = point.transforms[k]
        pose = to_placement(transform.translation, transform.rotation, place)
        poses.append(placed(origin, pose, place))
        if twists is not None:
            twist = to_twist_vector(point.velocities[k], f"{place}.velocities")
            twists[i] = twist if origin is None else turned(origin, twist)
    return poses, twists


def room_for_rates(message: Any, shape: tuple[int, int], count: int, where: str) -> Matrix | None:
    """Return room for the velocities of all points, or None where none has any."""
    lengths = {len(point.velocities) for point in message.points}
    if lengths == {0}:
        return None
    if lengths != {count}:
        raise InputError(f"{where}: points: velocities: expected {count} at every point, or none")
    return np.zeros(shape)


def to_twist_vector(twist: Any, where: str) -> Vector:
    """Return a checked twist, in the axes of its message."""
    value = to_vector(_numbers(twist), 6, f"{where}: twist")
    fastest = float(np.abs(value).max())
    if fastest > _FASTEST:
        raise InputError(f"{where}: twist: {fastest:g}, at most {_FASTEST:g} m/s or rad/s")
    return value


def _numbers(value: Any) -> list[float]:
    """Return the numbers of a twist, or the number that it is."""
    if isinstance(value, float | int):
        return [float(value)]
    parts = (value.linear, value.angular)
    return [number for part in parts for number in (part.x, part.y, part.z)]


def turned(origin: Pose, twist: Vector) -> Vector:
    """Return a twist that is told in the axes of a frame, in those of the world."""
    turn = origin.rotation
    return np.concatenate((turn @ twist[:3], turn @ twist[3:]))


def order_of(names: Sequence[str], joints: Sequence[str], robot: str, where: str) -> list[int]:
    """Return the place of each named joint in the arm; all must be there, in any order."""
    short = [name.removeprefix(f"{robot}/") for name in names]
    for name in short:
        if name not in joints or short.count(name) > 1:
            twice = name in joints
            what = "stands in it twice" if twice else f"unknown; known: {', '.join(joints)}"
            raise InputError(f"{where}: joint_names: {shown(name)}: {what}")
    missing = [joint for joint in joints if joint not in short]
    if missing:
        raise InputError(f"{where}: joint_names: {', '.join(missing)} missing")
    return [list(joints).index(name) for name in short]


def check_inside(values: Matrix, model: RobotModel, where: str) -> None:
    """Raise InputError for positions beyond the limits."""
    lower, upper = (
        x[model.arm] for x in (model.limits.position_lower, model.limits.position_upper)
    )
    beyond = np.argwhere((values < lower) | (values > upper))
    if len(beyond):
        k, j = (int(place) for place in beyond[0])
        raise InputError(
            f"{where}: points[{k}].positions: {model.joints[model.arm][j]}: {values[k, j]:g} is "
            f"outside its limits [{lower[j]:g}, {upper[j]:g}]"
        )


def made(where: str, make: Callable[[], Made]) -> Made:
    """Return a trajectory; raises InputError with the topic."""
    try:
        return make()
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
