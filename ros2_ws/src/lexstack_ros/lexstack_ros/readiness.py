"""When a node may be relied on: it hears the plant, and its peers hear it."""

from __future__ import annotations

from collections.abc import Mapping

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

READY = "ready"
_PERIOD = 0.1  # s of wall time between two looks


class Readiness:
    """Prints ``ready`` on standard output, once, for whoever started the process."""

    def __init__(self, node: Node, listeners: Mapping[str, str]) -> None:
        """Wait for the plant, and for each topic's listener, given as topic -> node name."""
        self._node = node
        self._listeners = listeners
        self.heard_plant = False
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(_PERIOD, self._look, clock=wall)

    def _look(self) -> None:
        """Say so when all is there."""
        if self.heard_plant and all(map(self._is_heard, self._listeners)):
            self._timer.cancel()
            print(READY, flush=True)

    def _is_heard(self, topic: str) -> bool:
        """Return whether the topic's listener has subscribed."""
        ends = self._node.get_subscriptions_info_by_topic(topic)
        return any(end.node_name == self._listeners[topic] for end in ends)
