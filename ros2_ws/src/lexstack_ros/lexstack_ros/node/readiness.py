"""When a node may be relied on: it is connected with its peers, both ways.

A volatile reader drops what comes before it knows the writer, and a writer that knows the reader
cannot tell: so each process looks at its own side before it says that it is ready.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo

from lexstack_ros.node.parameters import text_parameter

READY = "ready"
_PERIOD = 0.1  # s of wall time between two looks
_TELL = 5.0  # s between two lines about what is missing
_SETTLED = 0.5  # s for which nothing may be missing: endpoints come one by one


def missing_connections(node: Node, peers: Collection[str]) -> str:
    """Return what is still missing until ``is_connected``, in words; '' if nothing is."""
    away = sorted(set(peers) - _neighbours(node))
    if away:
        return f"waits for {', '.join(away)}"
    return "" if is_connected(node, peers) else "waits for topics to be connected"


def is_connected(node: Node, peers: Collection[str]) -> bool:
    """Return whether all peers are there, and every topic shared with them is connected.

    Args:
        node: whose publishers and subscriptions are looked at.
        peers: names of other nodes, in the namespace of this one.
    """
    if not set(peers) <= _neighbours(node):
        return False

    def count(ends: Iterable[TopicEndpointInfo]) -> int:
        mine = node.get_namespace()
        return sum(end.node_name in peers and end.node_namespace == mine for end in ends)

    heard = all(
        publisher.get_subscription_count()
        >= count(node.get_subscriptions_info_by_topic(publisher.topic_name))
        for publisher in node.publishers
    )
    return heard and all(
        subscription.get_publisher_count()
        >= count(node.get_publishers_info_by_topic(subscription.topic_name))
        for subscription in node.subscriptions
    )


def _neighbours(node: Node) -> set[str]:
    """Return the names of the nodes in a node's namespace: another cell has the same names."""
    mine = node.get_namespace()
    return {name for name, place in node.get_node_names_and_namespaces() if place == mine}


class Readiness:
    """Prints ``ready`` on standard output, once, for whoever started the process.

    Attributes:
        hears_plant: set by the node once a state of the plant has come.
    """

    def __init__(
        self, node: Node, *, hears_plant: bool, on_ready: Callable[[], None] = lambda: None
    ) -> None:
        """Wait for the plant, and for the nodes that the parameter ``peers`` names.

        ``on_ready`` is called right before the word is printed.
        """
        self._node = node
        self._on_ready = on_ready
        self.hears_plant = hears_plant
        names = text_parameter(node, "peers", "nodes to connect with first, comma-separated", "")
        self._peers = [name.strip() for name in names.split(",") if name.strip()]
        self._since = time.monotonic()
        self._reported = self._since
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(_PERIOD, self._look, clock=wall)

    def _look(self) -> None:
        """Say so when all has been there for a while; without peers there is nobody to wait for."""
        now = time.monotonic()
        if not self.hears_plant or not is_connected(self._node, self._peers):
            self._since = now
            self._tell(now)
        elif not self._peers or now - self._since >= _SETTLED:
            self._timer.cancel()
            self._on_ready()
            print(READY, flush=True)

    def _tell(self, now: float) -> None:
        """Say now and then what is missing."""
        if now - self._reported >= _TELL:
            self._reported = now
            what = missing_connections(self._node, self._peers)
            self._node.get_logger().info(what or "waits for a state of the plant")
