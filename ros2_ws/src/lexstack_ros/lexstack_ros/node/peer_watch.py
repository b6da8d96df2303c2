"""Who of the others is silent: every node of ours speaks once a second in /diagnostics."""

from __future__ import annotations

import time
from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.diagnostics import OURS, full_name

_SILENT = 2.5  # s of wall time: two and a half reports
_GONE = 60.0  # s after which a node is not missed any more: it has left for good


class PeerWatch:
    """The nodes of the same namespace that were heard, and since when each is silent."""

    def __init__(self, node: Node, clock: Callable[[], float] = time.monotonic) -> None:
        """Listen from ``node``, which is not watched itself; ``clock`` is monotonic [s]."""
        self._own = full_name(node)
        self._cell = self._own.rpartition("/")[0]
        self._clock = clock
        self._heard: dict[str, float] = {}
        node.create_subscription(DiagnosticArray, "diagnostics", self.hear, STREAM)

    def hear(self, message: DiagnosticArray) -> None:
        """Take note of who speaks."""
        for status in message.status:
            cell = status.name.rpartition("/")[0]
            ours = status.hardware_id == OURS and cell == self._cell
            if ours and status.name != self._own:
                self._heard[status.name] = self._clock()

    def report(self) -> str:
        """Return who is silent and since when, or ''."""
        now = self._clock()
        self._heard = {name: at for name, at in self._heard.items() if now - at < _GONE}
        silent = [(name, now - at) for name, at in self._heard.items() if now - at > _SILENT]
        return ", ".join(f"{name} is silent for {age:.0f} s" for name, age in sorted(silent))
