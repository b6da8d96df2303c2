"""When a node may be relied on: it hears the plant, and its peers hear it."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher

READY = "ready"
_PERIOD = 0.1  # s of wall time between two looks


def is_heard(node: Node, publisher: Publisher, listeners: Collection[str]) -> bool:
    """Return whether every one of the nodes named ``listeners`` gets what is published.

    The graph tells who subscribes, the publisher how many of them it is connected with.
    """
    known = node.get_subscriptions_info_by_topic(publisher.topic_name)
    names = {end.node_name for end in known}
    return names.issuperset(listeners) and publisher.get_subscription_count() >= len(known)


class Readiness:
    """Prints ``ready`` on standard output, once, for whoever started the process."""

    def __init__(self, node: Node, listeners: Mapping[Publisher, str]) -> None:
        """Wait for the plant, and until the node named hears what each publisher says."""
        self._node = node
        self._listeners = listeners
        self.heard_plant = False
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(_PERIOD, self._look, clock=wall)

    def _look(self) -> None:
        """Say so when all is there."""
        if self.heard_plant and all(
            is_heard(self._node, publisher, (name,)) for publisher, name in self._listeners.items()
        ):
            self._timer.cancel()
            print(READY, flush=True)
