"""The running system in Foxglove: every topic, as bytes, to whoever asks for it.

The optional package foxglove-sdk serves them at ws://127.0.0.1. A topic is subscribed to while
somebody looks at it, and its messages go on as they came: nothing is decoded here. Nothing is taken
either: a WebSocket of this kind knows no origin, so any page of a browser on this machine may read
the run, and none may move the robots.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from lexstack.errors import ConfigurationError
from lexstack.options import shown
from lexstack_bag.errors import BagError
from lexstack_bag.storage.definitions import message_definition
from lexstack_ros.recorder.topics import is_hidden, matching_qos, message_class

_HOST = "127.0.0.1"
_LOOK = 0.2  # s of wall time between two looks at what is asked for
_SEARCH = 5  # looks between two searches for new topics
_DEPTH = 50
_MOST = 65535  # of ports
_CLOCK_SIZE = 12  # bytes of a message
_CLOCK = "rosgraph_msgs/msg/Clock"
_MISSING = "Foxglove: the package foxglove-sdk is not there: pip install foxglove-sdk"


@dataclass
class _Topic:
    """One topic.

    Attributes:
        kind: the class of its messages.
        channel: the SDK's.
        subscription: while somebody looks.
        latched: its last message, where late subscribers are to have that.
    """

    kind: type
    channel: Any
    subscription: Subscription | None = None
    latched: bytes | None = None


@dataclass
class _Asked:
    """Hears, in a thread of the SDK, that a client has subscribed."""

    topics: SimpleQueue[str] = field(default_factory=SimpleQueue)

    def on_subscribe(self, _client: Any, channel: Any) -> None:
        """Take note."""
        self.topics.put(channel.topic)

    def __getattr__(self, name: str) -> Callable[..., None]:
        """Answer to all else that may happen: nothing is done."""
        if not name.startswith("on_"):
            raise AttributeError(name)
        return lambda *_arguments: None


class Foxglove:
    """Serves all topics of a node's namespace and domain.

    Attributes:
        url: where.
    """

    def __init__(self, node: Node, port: int, meshes: Mapping[str, Path] | None = None) -> None:
        """Serve from now on.

        Args:
            node: that subscribes.
            port: of the server; 0: any free one.
            meshes: files by the names that robots' descriptions have for them.

        Raises:
            ConfigurationError: foxglove-sdk is not installed, or the port is taken.
        """
        foxglove = _sdk()
        self._sdk, self._node, self._asked = foxglove, node, _Asked()
        self._context = foxglove.Context()
        self._topics: dict[str, _Topic] = {}
        self._unknown: set[str] = set()  # of types that are not installed
        self._now: int | None = None  # ns of simulated time; None: the wall's counts
        self._looks = 0
        try:
            self._server = foxglove.start_server(
                name="lexstack",
                host=_HOST,
                port=port,
                context=self._context,
                server_listener=self._asked,
                capabilities=[foxglove.Capability.Time],
                asset_handler=partial(_read, meshes or {}),
            )
        except Exception as error:  # the SDK has no narrower class for a taken port
            raise ConfigurationError(f"Foxglove: port {port}: {error}") from error
        self.url = f"ws://{_HOST}:{self._server.port}"
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(_LOOK, self._look, clock=wall)

    def close(self) -> None:
        """Send the clients away."""
        self._server.stop()

    def _look(self) -> None:
        """Subscribe to what is looked at, and to nothing else."""
        if self._looks % _SEARCH == 0:
            self._search()
        self._looks += 1
        for name, topic in self._topics.items():
            wanted = topic.channel.has_sinks()
            if wanted and topic.subscription is None:
                self._subscribe(name, topic)
            elif not wanted and topic.subscription is not None:
                self._node.destroy_subscription(topic.subscription)
                topic.subscription, topic.latched = None, None
        self._say_again()

    def _say_again(self) -> None:
        """Give a client that comes late the last message of a latched topic."""
        while True:
            try:
                topic = self._topics[self._asked.topics.get_nowait()]
            except Empty:
                return
            if topic.latched is not None:
                self._log(topic, topic.latched)

    def _search(self) -> None:
        """Offer topics that are new."""
        for name, kinds in self._node.get_topic_names_and_types():
            if is_hidden(name) or name in self._topics or name in self._unknown:
                continue
            try:
                kind, text = message_class(kinds[0]), message_definition(kinds[0])
            except BagError:
                self._unknown.add(name)
                continue
            schema = self._sdk.Schema(name=kinds[0], encoding="ros2msg", data=text.encode())
            self._topics[name] = _Topic(
                kind,
                self._sdk.Channel(
                    name, schema=schema, message_encoding="cdr", context=self._context
                ),
            )
            if kinds[0] == _CLOCK:
                qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
                self._node.create_subscription(kind, name, self._on_clock, qos, raw=True)

    def _subscribe(self, name: str, topic: _Topic) -> None:
        """Hear a topic as bytes; best effort, so that a slow browser holds nobody up."""
        qos = matching_qos(self._node.get_publishers_info_by_topic(name))
        qos.depth = _DEPTH
        latched = qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
        if not latched:
            qos.reliability = ReliabilityPolicy.BEST_EFFORT

        def hear(data: bytes) -> None:
            if latched:
                topic.latched = data
            self._log(topic, data)

        topic.subscription = self._node.create_subscription(topic.kind, name, hear, qos, raw=True)

    def _log(self, topic: _Topic, data: bytes) -> None:
        """Send a message on."""
        topic.channel.log(data, log_time=self._now)

    def _on_clock(self, data: bytes) -> None:
        """Take the simulated time; a clock is two numbers after four bytes of the encoding.

        What is no clock, or before 0, which the SDK has no number for, is left out.
        """
        if len(data) < _CLOCK_SIZE:
            return
        order = "<" if data[1] else ">"
        sec, nanosec = struct.unpack_from(f"{order}iI", data, 4)
        if sec < 0:
            return
        self._now = sec * 1_000_000_000 + nanosec
        self._server.broadcast_time(self._now)


def check_foxglove(port: str) -> int:
    """Return the port in a text; raises ConfigurationError: it is none, or there is no SDK."""
    digits = port.isascii() and port.isdigit() and len(port) <= len(str(_MOST))
    if not digits or int(port) > _MOST:
        raise ConfigurationError(f"foxglove: expected a port from 0 to {_MOST}, got {shown(port)}")
    _sdk()
    return int(port)


def _sdk() -> Any:
    """Return the SDK, which is optional; raises ConfigurationError."""
    try:
        import foxglove  # noqa: PLC0415

        _ = foxglove.start_server  # another package has the same name
    except (ImportError, AttributeError) as error:
        raise ConfigurationError(_MISSING) from error
    return foxglove


def _read(meshes: Mapping[str, Path], name: str) -> bytes | None:
    """Return the content of a mesh, or None: other files are not read."""
    return meshes[name].read_bytes() if name in meshes else None
