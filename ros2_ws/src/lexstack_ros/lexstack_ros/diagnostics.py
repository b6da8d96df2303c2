"""One diagnostic status per node, once a second of wall time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node


@dataclass(frozen=True, slots=True)
class Health:
    """How a node is.

    Attributes:
        message: one line; empty: all is well.
        values: figures with their units in the key.
    """

    message: str = ""
    values: dict[str, str] = field(default_factory=dict)


class Diagnostics:
    """Publishes a node's health to /diagnostics."""

    def __init__(self, node: Node, health: Callable[[], Health], period: float = 1.0) -> None:
        """Ask ``health`` every ``period`` seconds of wall time."""
        self._node = node
        self._health = health
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        node.create_timer(period, self._publish, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _publish(self) -> None:
        """Publish once."""
        health = self._health()
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if health.message else DiagnosticStatus.OK,
            name=self._node.get_name(),
            message=health.message or "ok",
            hardware_id="lexstack",
            values=[KeyValue(key=key, value=value) for key, value in health.values.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
