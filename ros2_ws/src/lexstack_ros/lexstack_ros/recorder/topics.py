"""What the recorder knows of ROS topics: which to take, with which QoS, and how to take them."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from lexstack_bag.errors import BagError
from lexstack_bag.run.loss import LossCounter
from lexstack_bag.storage.metadata import Qos, Topic
from lexstack_ros.intake.delays import with_info

# Messages that may wait while a chunk is compressed, the disk is slow or the processor busy.
_DEPTH = 10_000
_NS = 1_000_000_000

Store = Callable[[str, bytes, dict[str, Any]], None]


def is_hidden(topic: str) -> bool:
    """Return whether a topic is an internal one of ROS, such as an action's."""
    return any(part.startswith("_") for part in topic.split("/"))


def message_class(type_name: str) -> type:
    """Return the Python class of ``pkg/msg/Type``; raises BagError if it is not installed."""
    package, _, kind = type_name.partition("/msg/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), kind)  # type: ignore[no-any-return]
    except (ImportError, AttributeError) as error:
        raise BagError(f"{type_name}: no such message is installed") from error


def matching_qos(offers: list[TopicEndpointInfo]) -> QoSProfile:
    """Return the strictest profile that every publisher of a topic fulfils.

    Without publishers: reliable and volatile, what lexstack's own topics offer.
    """
    profiles = [offer.qos_profile for offer in offers]
    reliable = all(p.reliability == ReliabilityPolicy.RELIABLE for p in profiles)
    latched = profiles and all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=(DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE),
    )


def hears(qos: QoSProfile, offers: list[TopicEndpointInfo]) -> bool:
    """Return whether a subscription with this profile hears all of these publishers."""
    profiles = [offer.qos_profile for offer in offers]
    return not (
        qos.reliability == ReliabilityPolicy.RELIABLE
        and any(p.reliability == ReliabilityPolicy.BEST_EFFORT for p in profiles)
    ) and not (
        qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
        and any(p.durability == DurabilityPolicy.VOLATILE for p in profiles)
    )


def describe(name: str, type_name: str, offers: list[TopicEndpointInfo]) -> Topic:
    """Return a topic as the bag describes it, from its publishers' endpoints."""
    hashes = [str(offer.topic_type_hash) for offer in offers]
    return Topic(
        name,
        type_name,
        tuple(_qos(offer.qos_profile) for offer in offers),
        next((text for text in hashes if text.startswith("RIHS")), ""),
    )


def _qos(profile: QoSProfile) -> Qos:
    """Return a publisher's profile in rosbag2's words."""

    def time(duration: Any) -> dict[str, int]:
        sec, nsec = divmod(duration.nanoseconds, _NS)
        return {"sec": sec, "nsec": nsec}

    return Qos(
        history=profile.history.short_key,
        depth=profile.depth,
        reliability=profile.reliability.short_key,
        durability=profile.durability.short_key,
        deadline=time(profile.deadline),
        lifespan=time(profile.lifespan),
        liveliness=profile.liveliness.short_key,
        liveliness_lease_duration=time(profile.liveliness_lease_duration),
        avoid_ros_namespace_conventions=profile.avoid_ros_namespace_conventions,
    )


class Tap:
    """A raw subscription to one topic: hands over every message and counts the lost ones.

    It listens to no QoS event. rmw_fastrtps 8.4 takes two locks in one order where it notices a
    lost message, and in the other where that event is taken: under load the process stands still.

    Attributes:
        topic: its name.
        type_name: its type, pkg/msg/Type.
        qos: the profile with which it subscribed.
        publishers: how many were there when that profile was last looked at.
        shared: whether several publishers were seen on the topic at the same time. Messages do
            not say who sent them, so gaps between numbers then prove nothing, and nothing is
            counted.
    """

    def __init__(
        self, node: Node, topic: str, type_name: str, qos: QoSProfile, store: Store
    ) -> None:
        """Subscribe; ``store`` gets topic, bytes and message info of each message."""
        self.topic = topic
        self.type_name = type_name
        self.qos = qos
        self.publishers = 0
        self.shared = False
        self._store = store
        self._counter = LossCounter()
        self._before = 0  # counted when the recording began
        self._class = message_class(type_name)
        self._subscription: Subscription = node.create_subscription(
            self._class,
            topic,
            with_info(self._take),
            qos,
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )

    @property
    def lost(self) -> int:
        """Messages that were sent since the recording began and never came.

        Of a topic that is sent best effort none: nobody must have all of them.
        """
        reliable = self.qos.reliability == ReliabilityPolicy.RELIABLE
        return max(self._counter.lost - self._before, 0) if reliable and not self.shared else 0

    def begin(self) -> None:
        """Count from now on: what was sent while processes found each other is no loss."""
        self._before = self._counter.lost

    def drain(self) -> None:
        """Take what still waits in the middleware: nothing that arrived may be left out."""
        with self._subscription.handle:
            while True:
                item = self._subscription.handle.take_message(self._class, True)
                if item is None:
                    return
                self._take(*item)

    def remove(self, node: Node) -> None:
        """Unsubscribe."""
        node.destroy_subscription(self._subscription)

    def _take(self, data: bytes, info: dict[str, Any]) -> None:
        """Count and store one message."""
        number = info["publication_sequence_number"]
        if number is not None:
            self._counter.see(number)
        self._store(self.topic, data, info)
