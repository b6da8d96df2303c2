"""Plays a bag over DDS, to whoever listens or to one live node, tick by tick."""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable
from typing import Any

import numpy as np
import yaml
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock

from lexstack_bag.errors import BagError
from lexstack_bag.replay.requests import Ask, Cancel
from lexstack_bag.storage.container import Container, RawMessage
from lexstack_bag.storage.decoder import Decoder
from lexstack_bag.storage.definitions import type_hash
from lexstack_bag.storage.selection import Selection
from lexstack_bag.topics import PLANT_STATE
from lexstack_bringup.live_peer import LivePeer
from lexstack_interfaces.msg import Chi, PlantState
from lexstack_ros.messages.cdr_layout import fields_of
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_ros.node.calls import not_taken, wait_until
from lexstack_ros.recorder.topics import message_class

NAME = "replay"
_SETTLED = 1.0  # s for which all connections must have been there
_ALONE = 5.0  # s, after which it plays for nobody: discovery may take 3 s, a period of DDS
_NS = 1e9
_GROWN = {"lexstack_interfaces/msg/Chi": Chi}
"""Types that have all fields of their older versions: what they did not have is left empty."""
_OWN = ("/rosout", "/parameter_events")  # of the recorded nodes, not for live ones


class BagPlayer(Node):
    """Publishes recorded messages, and waits for a live node tick by tick.

    Attributes:
        peer: the live node, None where all is played.
    """

    def __init__(
        self,
        executor: Executor,
        container: Container,
        selection: Selection,
        live: str,
        patience: float,
    ) -> None:
        """Offer the topics of a bag.

        Args:
            executor: runs this node alone.
            container: the bag, read once, so that its topics are known.
            selection: which topics are played.
            live: a key of LIVE, or empty: nobody is waited for.
            patience: how long to wait for a live node [s of wall time].

        Raises:
            BagError: the bag has a topic whose type is not installed, or another one now.
        """
        super().__init__(NAME)
        executor.add_node(self)
        self._executor = executor
        self._patience = patience
        self.peer = LivePeer(live, self, executor, patience) if live else None
        self._older: dict[str, type] = {}  # topics whose messages are to be made anew
        self._decode = Decoder()
        leave = (*_OWN, *(self.peer.live.topics if self.peer else ()))
        self._publishers_by_topic: dict[str, Publisher] = {
            topic: self._offer(topic, kind, metadata)
            for topic, (kind, metadata) in container.topics.items()
            if topic not in leave and selection.takes(topic, kind)
        }
        self._clock = None
        if "/clock" not in container.topics and PLANT_STATE in self._publishers_by_topic:
            self._clock = self.create_publisher(Clock, "clock", STREAM)

    @property
    def topics(self) -> tuple[str, ...]:
        """What is played."""
        return tuple(self._publishers_by_topic)

    def wait_connected(self) -> None:
        """Wait until the live node is there and connected; raises BagError.

        Without one, wait for whoever listens: until nobody has joined for a while.
        """
        if self.peer is None:
            self._wait_settled()
        else:
            self.peer.wait_connected()

    def play(
        self,
        messages: Any,
        pace: Callable[[int], float],
        user: list[Ask | Cancel],
        expected: set[int],
    ) -> int:
        """Publish messages; return how many.

        Args:
            messages: of the bag, in its order.
            pace: from a log time [ns] to the wall time until it is due [s]; not positive: now.
            user: what is asked of a live controller by service.
            expected: ticks that the live node must answer before the next state is sent.

        Raises:
            BagError: a live node does not answer.
        """
        decode, played, served = self._decode, 0, -1
        for message in messages:
            publisher = self._publishers_by_topic.get(message.topic)
            if publisher is None:
                continue
            due = pace(message.log_time)
            if due > 0.0:
                wait_until(self._executor, lambda: False, due)
            if message.topic == PLANT_STATE:
                state = decode(message)
                if self.peer is not None:
                    self.peer.wait_answered(served, expected)
                if state.status != PlantState.PAUSED and state.tick > served:
                    if self.peer is not None:
                        self.peer.ask(user, state.tick)
                    served = state.tick
                self._tell_time(state)
            publisher.publish(self._altered(message))
            played += 1
        if self.peer is not None:
            self.peer.wait_answered(served, expected)
        clock = [] if self._clock is None else [self._clock]
        for topic in not_taken([*self._publishers_by_topic.values(), *clock], self._patience):
            self.get_logger().warning(f"{topic}: not taken by all listeners")
        return played

    def _offer(self, topic: str, kind: str, metadata: dict[str, str]) -> Publisher:
        """Return the publisher of a recorded topic."""
        recorded = metadata.get("topic_type_hash", "")
        if recorded and recorded != type_hash(kind):
            if kind not in _GROWN:
                raise BagError(f"{topic}: {kind} is another type now than when it was recorded")
            self._older[topic] = _GROWN[kind]
        return self.create_publisher(message_class(kind), relative(topic), _qos(metadata))

    def _tell_time(self, state: Any) -> None:
        """Publish /clock where the bag has none."""
        if self._clock is not None:
            stamp = state.header.stamp
            time_message = Clock()
            time_message.clock.sec, time_message.clock.nanosec = stamp.sec, stamp.nanosec
            self._clock.publish(time_message)

    def _altered(self, message: RawMessage) -> Any:
        """Return a message as it is played.

        The plant follows the live controller as it followed the recorded one: the name of the
        commander in its state is the live node's.
        """
        if message.topic in self._older:
            return filled(self._older[message.topic](), self._decode(message))
        if message.topic != PLANT_STATE or self.peer is None or not self.peer.sender:
            return bytes(message.data)
        state = deserialize_message(bytes(message.data), PlantState)
        if state.commander:
            state.commander = self.peer.sender
        return state

    def _wait_settled(self) -> None:
        """Wait until somebody listens, and nobody else has joined for a while."""
        since = time.monotonic()
        end, listeners = since + self._patience, 0
        while (now := time.monotonic()) - since < (_SETTLED if listeners else _ALONE) and now < end:
            self._executor.spin_once(timeout_sec=0.1)
            present = sum(p.get_subscription_count() for p in self._publishers_by_topic.values())
            if present != listeners:
                since, listeners = now, present


def filled(message: Any, older: Any) -> Any:
    """Return a generated message with the fields of a decoded one of an older version."""
    for field in fields_of(type(message)):
        value = getattr(older, field.name, None)
        if value is None:
            continue
        if not field.kind and field.count is None:
            filled(getattr(message, field.name), value)
        else:
            numbers = isinstance(value, np.ndarray)
            setattr(message, field.name, array(value.dtype.char, value) if numbers else value)
    return message


def _qos(metadata: dict[str, str]) -> Any:
    """Return the house's profile that fits what was offered when it was recorded."""
    offered = yaml.safe_load(metadata.get("offered_qos_profiles", "")) or []
    latched = any(profile.get("durability") == "transient_local" for profile in offered)
    return LATCHED if latched else STREAM


def paced(rate: float) -> Callable[[int], float]:
    """Return when a message is due at a multiple of the recorded pace; 0: at once."""
    begun: list[tuple[int, float]] = []

    def due(log_time: int) -> float:
        if not rate:
            return 0.0
        if not begun:
            begun.append((log_time, time.monotonic()))
        first, wall = begun[0]
        return wall + (log_time - first) / _NS / rate - time.monotonic()

    return due
