"""The recorder: every topic, raw, into one bag."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from lexstack_bag.errors import BagError
from lexstack_bag.facts import run_facts
from lexstack_bag.metadata import Topic
from lexstack_bag.writer import BagWriter
from lexstack_core.config.resolved import ResolvedScenario
from lexstack_core.errors import ConfigurationError
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy

from lexstack_ros.recording import Tap, contract_topics, describe, is_hidden, matching_qos
from lexstack_ros.spin import run_node

_DISCOVERY_PERIOD = 0.2  # s
_REPORT_PERIOD = 1.0  # s


class Recorder(Node):
    """Writes all topics to a bag until it is closed, and counts what it missed."""

    def __init__(self) -> None:
        """Create the bag and subscribe; raises LexstackError for a wrong parameter."""
        super().__init__("recorder")
        output = Path(self._text("output", "folder of the bag; must not hold anything"))
        resolved = _read_scenario(Path(self._text("scenario", "the resolved scenario's file")))
        extra = self._text("topics", "more topics to wait for: NAME:TYPE, comma-separated", "")
        self._writer = BagWriter(output, run_facts(resolved))
        self._taps: dict[str, Tap] = {}
        self._announced: set[str] = set()
        self._refused: set[str] = set()
        self._lost_before: Counter[str] = Counter()  # of subscriptions that were renewed
        for name, type_name in {**contract_topics(resolved.scenario.robots), **_pairs(extra)}.items():
            self._subscribe(name, type_name)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        wall = Clock(clock_type=ClockType.STEADY_TIME)  # goes on while simulated time stands
        self.create_timer(_DISCOVERY_PERIOD, self._discover, clock=wall)
        self.create_timer(_REPORT_PERIOD, self._report, clock=wall)
        self._discover()
        self.get_logger().info(f"ready: records {len(self._taps)} topics to {output}")
        print("ready", flush=True)

    def close(self) -> None:
        """Take what still waits in the middleware, complete the bag, and say what it holds."""
        for tap in self._taps.values():
            tap.drain()
        lost = self._lost()
        self._writer.close(lost)
        missing = ", ".join(f"{topic} {count}" for topic, count in lost.items() if count)
        self.get_logger().info(
            f"recorded {self._writer.extent.total} messages of {len(self._announced)} topics, "
            f"{sum(lost.values())} lost{': ' if missing else ''}{missing}"
        )

    def _text(self, name: str, description: str, default: str | None = None) -> str:
        """Declare a text parameter and return it; without a default it must be given."""
        descriptor = ParameterDescriptor(description=description, read_only=True)
        value = str(self.declare_parameter(name, default or "", descriptor).value)
        if not value and default is None:
            raise ConfigurationError(f"recorder: parameter {name!r} ({description}) is missing")
        return value

    def _discover(self) -> None:
        """Subscribe to topics that are new, and anew where the QoS did not fit."""
        for name, types in self.get_topic_names_and_types():
            tap = self._taps.get(name)
            done = name in self._announced and tap is not None and not tap.incompatible
            if done or is_hidden(name) or name in self._refused:
                continue
            offers = self.get_publishers_info_by_topic(name)
            if not offers:
                continue
            qos = matching_qos(offers)
            too_strict = tap is not None and (
                tap.qos.reliability != qos.reliability == ReliabilityPolicy.BEST_EFFORT
            )
            if tap is None or too_strict:
                self._subscribe(name, types[0] if tap is None else tap.type_name, qos)
            self._announce(name)

    def _subscribe(self, name: str, type_name: str, qos: Any = None) -> None:
        """Record a topic from now on; an unknown type is refused once, with a warning."""
        old = self._taps.pop(name, None)
        if old is not None:
            old.drain()
            old.remove(self)
            self._lost_before[name] += old.lost
        try:
            self._taps[name] = Tap(self, name, type_name, qos or matching_qos([]), self._store)
        except BagError as error:
            self._refused.add(name)
            self.get_logger().warning(f"{name} is not recorded: {error}")

    def _announce(self, name: str) -> None:
        """Describe a topic in the bag, with the QoS that its publishers offer."""
        tap = self._taps.get(name)
        if tap is None or name in self._announced:
            return
        offers = self.get_publishers_info_by_topic(name)
        topic: Topic = describe(name, tap.type_name, offers)
        self._writer.add_topic(topic)
        self._announced.add(name)

    def _store(self, name: str, data: bytes, info: dict[str, Any]) -> None:
        """Write one message."""
        if name not in self._announced:
            self._announce(name)
        number = info["publication_sequence_number"] or 0
        self._writer.write(
            name, data, info["received_timestamp"], info["source_timestamp"], number
        )

    def _lost(self) -> dict[str, int]:
        """Return the number of lost messages by topic."""
        return {name: tap.lost + self._lost_before[name] for name, tap in self._taps.items()}

    def _report(self) -> None:
        """Put complete chunks on the disk and publish the state of the recording."""
        self._writer.flush()
        lost = sum(self._lost().values())
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if lost else DiagnosticStatus.OK,
            name="recorder",
            message=f"{lost} messages lost" if lost else "recording",
            hardware_id="lexstack",
            values=[
                KeyValue(key="messages", value=str(self._writer.extent.total)),
                KeyValue(key="topics", value=str(len(self._announced))),
                KeyValue(key="lost", value=str(lost)),
            ],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)


def _read_scenario(path: Path) -> ResolvedScenario:
    """Return the resolved scenario in a file; raises ConfigurationError."""
    try:
        return ResolvedScenario.from_yaml(path.read_text(encoding="utf-8"), str(path))
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read: {error.strerror}") from error


def _pairs(text: str) -> dict[str, str]:
    """Return names and types of ``NAME:TYPE, ...``; raises ConfigurationError."""
    pairs = [item.strip().split(":") for item in text.split(",") if item.strip()]
    if any(len(pair) != 2 for pair in pairs):
        raise ConfigurationError(f"recorder: topics: expected NAME:TYPE, ..., got {text!r}")
    return {name: type_name for name, type_name in pairs}


def main() -> int:
    """Run the recorder; returns the exit code."""
    return run_node(Recorder)


if __name__ == "__main__":
    sys.exit(main())
