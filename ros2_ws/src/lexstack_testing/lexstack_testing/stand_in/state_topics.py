"""What the robots of the stand-in measure, as messages: joint states, odometry, transforms."""

from __future__ import annotations

from array import array
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from lexstack.errors import InputError
from lexstack_config.plant_file import RobotInterfaceConfig
from lexstack_plant.hardware.base_intake import BaseSample
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_ros.messages.conversions import to_time
from lexstack_testing.stand_in.robots import Sent

STATES = QoSProfile(depth=10)


class StateTopics:
    """Publishes states. Messages are filled again and again: making them takes as long as sending.

    Two robots may share a topic of joint states.
    """

    def __init__(self, node: Node, epoch: int) -> None:
        """Publish nothing yet; times of samples are seconds since ``epoch`` [s since 1970]."""
        self._node, self._epoch = node, epoch
        self._joints, self._odometry = JointState(), Odometry(child_frame_id="base_link")
        self._topics: dict[str, Publisher] = {}
        self._joints_out: dict[str, Publisher] = {}
        self._odometry_out: dict[str, Publisher] = {}
        self._transforms_out: dict[str, tuple[Publisher, TFMessage]] = {}

    def add(self, name: str, config: RobotInterfaceConfig) -> None:
        """Advertise the topics of one robot."""
        self._joints_out[name] = self._advertise(JointState, config.joint_states.topic)
        if config.base is None:
            return
        if config.base.odometry is not None:
            self._odometry_out[name] = self._advertise(Odometry, config.base.odometry)
        tf: Any = getattr(config.base, "tf", None)
        if tf is not None:
            transform = TransformStamped(child_frame_id=tf.frame)
            transform.header.frame_id = tf.parent
            message = TFMessage(transforms=[transform])
            self._transforms_out[name] = (self._advertise(TFMessage, tf.topic), message)

    def publish(self, sent: Sent) -> None:
        """Send what a robot has measured."""
        name, sample = sent.robot, sent.sample
        stamp = to_time(sample.stamp)
        stamp.sec += self._epoch
        if isinstance(sample, JointSample):
            self._joints.header.stamp = stamp
            self._joints.name = list(sample.names)
            self._joints.position = array("d", sample.positions)
            self._joints.velocity = array("d", sample.velocities)
            self._joints_out[name].publish(self._joints)
            return
        if name in self._odometry_out:
            _fill_odometry(self._odometry, sample, stamp)
            self._odometry_out[name].publish(self._odometry)
        if name in self._transforms_out:
            out, message = self._transforms_out[name]
            _fill_transform(message.transforms[0], sample, stamp)
            out.publish(message)

    def _advertise(self, kind: type, topic: str) -> Publisher:
        """Return the publisher of a topic, one for all robots on it."""
        if topic not in self._topics:
            self._topics[topic] = self._node.create_publisher(kind, topic, STATES)
        return self._topics[topic]


def _fill_odometry(message: Odometry, sample: BaseSample, stamp: Time) -> None:
    """Write a platform's pose and velocity into a message."""
    if sample.twist is None:
        raise InputError("odometry without a twist")
    message.header.stamp, message.header.frame_id = stamp, sample.frame
    pose, twist = message.pose.pose, message.twist.twist
    pose.position.x, pose.position.y = sample.x, sample.y
    turn = pose.orientation
    turn.x, turn.y, turn.z, turn.w = map(float, sample.quaternion)
    twist.linear.x, twist.linear.y, twist.angular.z = map(float, sample.twist)


def _fill_transform(message: TransformStamped, sample: BaseSample, stamp: Time) -> None:
    """Write a platform's pose into a message."""
    message.header.stamp = stamp
    place, turn = message.transform.translation, message.transform.rotation
    place.x, place.y = sample.x, sample.y
    turn.x, turn.y, turn.z, turn.w = map(float, sample.quaternion)
