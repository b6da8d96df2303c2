"""The recorder: every topic, raw, into one bag."""

from __future__ import annotations

import sys
from collections import Counter
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile

from lexstack_bag.errors import BagError
from lexstack_bag.run.provenance import run_provenance
from lexstack_bag.storage.writer import BagWriter
from lexstack_bag.topics import NEEDED, contract_topics
from lexstack_ros.messages.names import relative
from lexstack_ros.node.diagnostics import Diagnostics, Health
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import scenario_parameter
from lexstack_ros.node.readiness import Readiness
from lexstack_ros.node.spin import beside, run_node
from lexstack_ros.recorder.options import RecordingOptions
from lexstack_ros.recorder.topics import (
    Tap,
    describe,
    hears,
    is_hidden,
    matching_qos,
)

_DISCOVERY_PERIOD = 0.2  # s
_FLUSH_PERIOD = 1.0  # s


class Recorder(Node):
    """Writes all topics to a bag until it is closed, and counts what it missed."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Create the bag and subscribe; raises LexstackError for a wrong parameter."""
        super().__init__(**options.arguments("recorder"))
        options = RecordingOptions.of(self)
        resolved = scenario_parameter(self)
        self.niceness = beside(resolved.scenario.mode)
        expected = contract_topics(resolved.scenario.robots) | options.expected
        self._selection = options.selection
        self._cell = self.get_namespace().rstrip("/")
        provenance = run_provenance(resolved, self._cell)
        self._writer = BagWriter(options.output, provenance, options.storage)
        self._taps: dict[str, Tap] = {}
        self._announced: set[str] = set()
        self._refused: set[str] = set()
        self._broken = ""  # why the bag ends here, while the run goes on
        self._lost_before: Counter[str] = Counter()  # of subscriptions that were renewed
        for plain, type_name in expected.items():
            ours = plain not in options.expected
            name = self.resolve_topic_name(relative(plain) if ours else plain)
            if self._selection.takes(name, type_name):
                self._subscribe(name, type_name)
            elif plain in NEEDED:
                self.get_logger().warning(f"{name} is left out: the bag cannot be analysed")
        self._diagnostics = Diagnostics(self, self._health)
        wall = Clock(clock_type=ClockType.STEADY_TIME)  # goes on while simulated time stands
        self.create_timer(_DISCOVERY_PERIOD, self._discover, clock=wall)
        self.create_timer(_FLUSH_PERIOD, self._flush, clock=wall)
        self._discover()
        self.get_logger().info(f"records {len(self._taps)} topics to {options.output}")
        self._readiness = Readiness(self, hears_plant=True, on_ready=self._begin)

    def close(self) -> None:
        """Take what still waits in the middleware, complete the bag, and say what it holds."""
        try:
            for tap in self._taps.values():
                tap.drain()
            lost = self._lost()
            self._writer.close(lost)
        except BagError as error:
            self.get_logger().error(f"the bag is not complete: {error}")
            return
        missing = ", ".join(f"{topic} {count}" for topic, count in lost.items() if count)
        self.get_logger().info(
            f"recorded {self._writer.extent.total} messages of {len(self._announced)} topics, "
            f"{sum(lost.values())} lost{': ' if missing else ''}{missing}"
        )

    def _begin(self) -> None:
        """Count losses from now on: all peers are connected."""
        for tap in self._taps.values():
            tap.begin()

    def _discover(self) -> None:
        """Subscribe to topics that are new, and anew where the QoS of a publisher does not fit."""
        for name, types in self.get_topic_names_and_types():
            if is_hidden(name) or name in self._refused or self._is_foreign(name):
                continue
            if not self._selection.takes(name, types[0]):
                continue
            tap, count = self._taps.get(name), self.count_publishers(name)
            if tap is not None:
                tap.shared = tap.shared or count > 1
            if not count or (tap is not None and tap.publishers == count):
                continue
            offers = self.get_publishers_info_by_topic(name)
            if tap is None or not hears(tap.qos, offers):
                type_name = types[0] if tap is None else tap.type_name
                self._subscribe(name, type_name, matching_qos(offers))
            if name in self._taps:
                self._taps[name].publishers = count
            self._announce(name)

    def _is_foreign(self, name: str) -> bool:
        """Return whether a topic is another cell's, or of all: outside of the own namespace."""
        return not name.startswith(f"{self._cell}/") and name not in self._taps

    def _subscribe(self, name: str, type_name: str, qos: QoSProfile | None = None) -> None:
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
        self._writer.add_topic(describe(name, tap.type_name, offers))
        self._announced.add(name)

    def _store(self, name: str, data: bytes, info: dict[str, Any]) -> None:
        """Write one message."""
        if self._broken:
            return
        number = info["publication_sequence_number"] or 0
        times = info["received_timestamp"], info["source_timestamp"]
        try:
            if name not in self._announced:
                self._announce(name)
            self._writer.write(name, data, *times, number)
        except BagError as error:
            self._give_up(error)

    def _flush(self) -> None:
        """Hand to the disk what has waited long enough."""
        if self._broken:
            return
        try:
            self._writer.flush()
        except BagError as error:
            self._give_up(error)

    def _give_up(self, error: BagError) -> None:
        """Let the bag end here, and say so: a full disk must not end the run."""
        self._broken = f"the bag ends here: {error}"
        self.get_logger().error(self._broken)

    def _lost(self) -> dict[str, int]:
        """Return the number of lost messages by topic."""
        return {name: tap.lost + self._lost_before[name] for name, tap in self._taps.items()}

    def _health(self) -> Health:
        """Return how the recording goes."""
        lost = sum(self._lost().values())
        return Health(
            f"{lost} messages lost" if lost else "",
            {
                "messages": str(self._writer.extent.total),
                "topics": str(len(self._announced)),
                "lost": str(lost),
            },
            error=self._broken,
        )


def main() -> int:
    """Run the recorder; returns the exit code."""
    return run_node(Recorder)


if __name__ == "__main__":
    sys.exit(main())
