"""Between the messages of ros2_control's controllers and values; nothing is checked here."""

from __future__ import annotations

from collections.abc import Sequence

from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lexstack.types import Vector
from lexstack_plant.hardware.base_intake import BaseSample
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.spline import Point
from lexstack_ros.messages.conversions import to_array, to_seconds


def joint_sample(message: JointState, received: float) -> JointSample:
    """Return a message of joints that came at ``received`` [s], by the local clock."""
    return JointSample(
        message.name,
        message.position,
        message.velocity,
        to_seconds(message.header.stamp),
        received,
    )


def base_sample(message: Odometry, received: float) -> BaseSample:
    """Return a message of odometry that came at ``received`` [s], by the local clock."""
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    twist = message.twist.twist
    return BaseSample(
        place.x,
        place.y,
        (turn.x, turn.y, turn.z, turn.w),
        (twist.linear.x, twist.linear.y, twist.angular.z),
        to_seconds(message.header.stamp),
        received,
        message.header.frame_id,
    )


def trajectory(names: Sequence[str], points: Sequence[Point], stamp: Time) -> JointTrajectory:
    """Return a trajectory that begins at ``stamp``."""
    message = JointTrajectory(joint_names=list(names))
    message.header.stamp = stamp
    message.points = [
        JointTrajectoryPoint(
            positions=to_array(point.position),
            velocities=to_array(point.velocity),
            accelerations=to_array(point.acceleration),
            time_from_start=to_duration(point.time),
        )
        for point in points
    ]
    return message


def values(vector: Vector) -> Float64MultiArray:
    """Return an array of one value per joint."""
    return Float64MultiArray(data=to_array(vector))


def twist_message(twist: Vector, stamp: Time, frame: str, *, stamped: bool) -> Twist | TwistStamped:
    """Return a platform's velocity along its own axes, shape (3,)."""
    bare = Twist()
    bare.linear.x, bare.linear.y, bare.angular.z = twist.tolist()
    if not stamped:
        return bare
    message = TwistStamped(twist=bare)
    message.header.stamp = stamp
    message.header.frame_id = frame
    return message


def to_duration(seconds: float) -> Duration:
    """Return a time [s] as a message."""
    nanoseconds = round(seconds * 1e9)
    return Duration(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)


def seconds_of(stamp: Time | Duration) -> float:
    """Return a stamp or a duration in seconds."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)
