"""Subscriptions and publishers of one robot that ros2_control drives."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64MultiArray
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory

from lexstack.errors import InputError
from lexstack_config.plant_file import BaseInterfaceConfig
from lexstack_plant.finding.endpoints import TRAJECTORY, TWIST, TWIST_STAMPED, VALUES
from lexstack_plant.hardware.clocks import HardwareClock
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.messages import (
    base_sample,
    joint_sample,
    trajectory,
    twist_message,
    values,
)
from lexstack_plant.hardware.outputs import RobotCommand
from lexstack_plant.hardware.robot import HardwareRobot
from lexstack_plant.hardware.transform_intake import TransformIntake
from lexstack_ros.intake.drain import waiting
from lexstack_ros.messages.qos import STATIC_TRANSFORMS, TRANSFORMS

# Best effort hears reliable and best-effort publishers alike; a state that was lost is old anyway.
_STATES = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
# Reliable, as the subscribers of ros2_control ask for; of commands the newest counts.
_COMMANDS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
_BASE = "base_link"
_NAMES = {
    JointTrajectory: TRAJECTORY,
    Float64MultiArray: VALUES,
    Twist: TWIST,
    TwistStamped: TWIST_STAMPED,
}
Refuse = Callable[[InputError], None]


class StateTopics:
    """Hears each topic once, whoever of the robots it is about."""

    def __init__(self, node: Node, refuse: Refuse) -> None:
        """Hear nothing yet; ``refuse`` is told of messages that do not fit."""
        self._node, self._refuse = node, refuse
        self._listeners: dict[tuple[type, str], list[Callable[[Any], None]]] = {}
        self._heard: dict[tuple[type, str], Subscription] = {}

    def take_waiting(self) -> None:
        """Hand on what has come while this process had no time."""
        for key, subscription in self._heard.items():
            for message, _ in waiting(subscription):
                self._hand_on(key, message)

    def add(
        self,
        kind: type,
        topic: str,
        listener: Callable[[Any], None],
        qos: QoSProfile = _STATES,
    ) -> None:
        """Call ``listener`` for every message of a topic; it may raise InputError."""
        key = (kind, topic)
        known = key in self._listeners
        self._listeners.setdefault(key, []).append(listener)
        if known:
            return
        subscription: Any = None

        def hear(message: Any) -> None:
            for each in (message, *(other for other, _ in waiting(subscription))):
                self._hand_on(key, each)

        subscription = self._node.create_subscription(kind, topic, hear, qos)
        self._heard[key] = subscription

    def _hand_on(self, key: tuple[type, str], message: Any) -> None:
        """Hand a message to all that want it."""
        for listener in self._listeners[key]:
            try:
                listener(message)
            except InputError as error:
                self._refuse(InputError(f"{key[1]}: {error}"))


class RobotTopics:
    """One robot's states in, its commands out."""

    def __init__(
        self,
        node: Node,
        robot: HardwareRobot,
        states: StateTopics,
        *,
        press: Callable[[bool], None],
        stop: str | None,
        clock: HardwareClock,
        hear: Callable[[JointSample], None],
    ) -> None:
        """Subscribe and advertise; ``stop`` is the topic of an emergency stop.

        ``hear`` takes what the arm's joints measure.
        """
        self._robot, self._clock, self._hear, self._node = robot, clock, hear, node
        self._transforms: TransformIntake | None = None
        config = robot.config
        states.add(JointState, config.joint_states.topic, self._on_joints)
        if config.base is not None:
            self._add_base(config.base, states)
        if stop is not None:
            states.add(Bool, stop, lambda message: press(bool(message.data)))
        kind = JointTrajectory if config.arm.type == "joint_trajectory" else Float64MultiArray
        self._arm_out = node.create_publisher(kind, config.arm.command, _COMMANDS)
        self._base_out = None
        if config.base is not None:
            self._stamped = config.base.type == "twist_stamped"
            twist = TwistStamped if self._stamped else Twist
            self._base_out = node.create_publisher(twist, config.base.command, _COMMANDS)

    def _add_base(self, config: BaseInterfaceConfig, states: StateTopics) -> None:
        """Hear where the platform is."""
        if config.odometry is not None:
            states.add(Odometry, config.odometry, self._on_odometry)
        if config.tf is None:
            return
        self._transforms = TransformIntake(config.tf)
        hear = self._on_transforms
        states.add(TFMessage, config.tf.topic, partial(hear, static=False), TRANSFORMS)
        still = f"{config.tf.topic}_static"
        states.add(TFMessage, still, partial(hear, static=True), STATIC_TRANSFORMS)

    def look(self) -> None:
        """Look whether somebody hears the commands: a controller that has died has no listener."""
        outs = [out for out in (self._arm_out, self._base_out) if out is not None]
        lost = (out for out in outs if not out.get_subscription_count())
        self._robot.unheard = next(map(self._unheard, lost), "")

    def _unheard(self, out: Publisher) -> str:
        """Return what is wrong with a topic that nobody hears, and what to do."""
        kind = _NAMES[out.msg_type]
        listeners = {
            info.topic_type for info in self._node.get_subscriptions_info_by_topic(out.topic_name)
        }
        if kind in listeners:
            help_ = "there is a listener, but it asks for another quality of service"
        elif listeners:
            help_ = f"there is a listener for {', '.join(sorted(listeners))}: correct the type"
        else:
            help_ = "start the controller"
        return f"nobody listens to {out.topic_name} ({kind}): {help_}"

    def send(self, command: RobotCommand) -> None:
        """Publish the commands of a tick; their stamps are those of the tick, not of now."""
        stamp = self._clock.stamp(command.due)
        if command.points:
            self._arm_out.publish(trajectory(self._robot.names, command.points, stamp))
        elif command.values is not None:
            self._arm_out.publish(values(command.values))
        if self._base_out is not None and command.twist is not None:
            message = twist_message(command.twist, stamp, _BASE, stamped=self._stamped)
            self._base_out.publish(message)

    def _on_joints(self, message: JointState) -> None:
        """Take a message of joints."""
        self._hear(joint_sample(message, self._clock.now()))

    def _on_odometry(self, message: Odometry) -> None:
        """Take a message of odometry; of a platform that /tf places its velocity."""
        base, sample = self._robot.base, base_sample(message, self._clock.now())
        if base is None:
            return
        if self._transforms is None:
            base.hear(sample)
        else:
            base.hear_twist(sample)

    def _on_transforms(self, message: TFMessage, static: bool) -> None:
        """Take a message of transforms."""
        if self._robot.base is None or self._transforms is None:
            return
        sample = self._transforms.hear(message.transforms, self._clock.now(), static=static)
        if sample is not None:
            self._robot.base.hear(sample)
