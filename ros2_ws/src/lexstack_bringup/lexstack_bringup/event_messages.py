"""The references of a scenario's events as messages: what a user would publish."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped, Transform, Twist, TwistStamped
from nav_msgs.msg import Path
from trajectory_msgs.msg import (
    JointTrajectory,
    JointTrajectoryPoint,
    MultiDOFJointTrajectory,
    MultiDOFJointTrajectoryPoint,
)

from lexstack.robots import Pose, from_rpy, to_quaternion
from lexstack_config.event_targets import poses_of, twist_times
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig, pose_from_config
from lexstack_config.trajectories import PathConfig, PostureWayConfig, TwistEventConfig, WayConfig
from lexstack_ros.messages.conversions import pose_message, stamped

TYPES: dict[str, type] = {
    "ee_target": PoseStamped,
    "base_target": PoseStamped,
    "ee_trajectory": MultiDOFJointTrajectory,
    "ee_twist": TwistStamped,
    "base_path": Path,
    "posture_trajectory": JointTrajectory,
}
"""Topics of references that a scenario uses, below a robot's name."""


def messages_of(event: EventConfig, resolved: ResolvedScenario) -> Iterator[tuple[str, Any]]:
    """Yield topic and message of each reference of an event, to take effect at its time."""
    for name, config in event.ee_target.items():
        pose = pose_from_config(config)
        yield f"/{name}/ee_target", pose_message(pose, event.at, np.array(config.orientation))
    for name, place in event.base_target.items():
        yield f"/{name}/base_target", _place(place, event.at)
    for name, way in event.ee_trajectory.items():
        yield f"/{name}/ee_trajectory", _way(way, event.at)
    for name, path in event.base_path.items():
        yield f"/{name}/base_path", _path(path, event.at)
    for name, posture in event.posture_trajectory.items():
        joints = resolved.robots[resolved.scenario.robots[name].model].arm.joints
        yield f"/{name}/posture_trajectory", _posture(posture, joints, event.at)
    for name, twist in event.ee_twist.items():
        for at in twist_times(twist, event.at):
            yield f"/{name}/ee_twist", _twist(twist, at)


def _place(place: Sequence[float], at: float) -> PoseStamped:
    """Return x, y, yaw as a message."""
    x, y, yaw = place
    pose = Pose(np.array([x, y, 0.0]), from_rpy((0.0, 0.0, yaw)))
    return pose_message(pose, at, to_quaternion(pose.rotation))


def _way(config: WayConfig, at: float) -> MultiDOFJointTrajectory:
    """Return timed poses as a message."""
    points = []
    for time, pose in zip(config.times, poses_of(config), strict=True):
        transform = Transform()
        place, turn = transform.translation, transform.rotation
        place.x, place.y, place.z = pose.position.tolist()
        turn.x, turn.y, turn.z, turn.w = to_quaternion(pose.rotation).tolist()
        points.append(
            MultiDOFJointTrajectoryPoint(transforms=[transform], time_from_start=_duration(time))
        )
    return stamped(MultiDOFJointTrajectory(joint_names=[config.frame], points=points), at)


def _path(config: PathConfig, at: float) -> Path:
    """Return places as a message; without times their stamps are 0."""
    stamps = [at + time for time in config.times] or [0.0] * len(config.places)
    poses = [_place(place, stamp) for place, stamp in zip(config.places, stamps, strict=True)]
    return stamped(Path(poses=poses), at)


def _posture(config: PostureWayConfig, joints: Sequence[str], at: float) -> JointTrajectory:
    """Return timed positions as a message."""
    points = [
        JointTrajectoryPoint(positions=list(row), time_from_start=_duration(time))
        for time, row in zip(config.times, config.positions, strict=True)
    ]
    return stamped(JointTrajectory(joint_names=list(joints), points=points), at)


def _twist(config: TwistEventConfig, at: float) -> TwistStamped:
    """Return a twist as a message."""
    twist = Twist()
    for part, values in ((twist.linear, config.linear), (twist.angular, config.angular)):
        part.x, part.y, part.z = map(float, values)  # files may have integers
    return stamped(TwistStamped(twist=twist), at)


def _duration(seconds: float) -> Duration:
    """Return a time from the start as a message."""
    nanoseconds = round(1e9 * seconds)
    return Duration(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
