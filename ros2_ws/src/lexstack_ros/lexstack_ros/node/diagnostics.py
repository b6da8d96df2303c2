"""One diagnostic status per node, once a second of wall time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

OURS = "lexstack"
"""The hardware_id of every status of ours."""

_LONGEST = 500  # characters of a message or value


@dataclass(frozen=True, slots=True)
class Health:
    """How a node is.

    Attributes:
        message: one line of what is not as it should be, WARN; empty: all is well, OK.
        values: figures with their units in the key.
        error: one line: why the node cannot do, or did not do, its work since the last report,
            ERROR; empty: it can.
        stale: whether the figures are old, as nothing came that they could be made from, STALE.
    """

    message: str = ""
    values: dict[str, str] = field(default_factory=dict)
    error: str = ""
    stale: bool = False

    @property
    def level(self) -> bytes:
        """The level of diagnostic_msgs; what must be looked at first wins."""
        if self.error:
            return DiagnosticStatus.ERROR
        if self.stale:
            return DiagnosticStatus.STALE
        return DiagnosticStatus.WARN if self.message else DiagnosticStatus.OK


class Meter:
    """How often a node does its work, and how long it takes, since the last report."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin now; ``clock`` is monotonic [s]."""
        self._clock = clock
        self._since = clock()
        self._times: list[float] = []

    def add(self, seconds: float) -> None:
        """Take note of one piece of work that took so long [s]."""
        self._times.append(seconds)

    def report(self) -> dict[str, str]:
        """Return rate, median and longest time since the last report, and begin anew."""
        now, times = self._clock(), sorted(self._times)
        span, self._since, self._times = now - self._since, now, []
        values = {"rate [Hz]": f"{len(times) / span:.1f}" if span > 0.0 else "0.0"}
        if times:
            values["solve time, median [us]"] = f"{1e6 * times[len(times) // 2]:.0f}"
            values["solve time, longest [us]"] = f"{1e6 * times[-1]:.0f}"
        return values


def first(*complaints: str) -> str:
    """Return the first complaint that is one, or '': one line is shown, the worst first."""
    return next((complaint for complaint in complaints if complaint), "")


def all_of(*complaints: str) -> str:
    """Return all complaints in one line, or '': of different things none may hide another."""
    return "; ".join(complaint for complaint in complaints if complaint)


def brief(text: str) -> str:
    """Return a text as it may stand in a status: a long one cut, with how long it was."""
    if len(text) <= _LONGEST:
        return text
    tail = f"… ({len(text)} characters)"
    return text[: _LONGEST - len(tail)] + tail


def full_name(node: Node) -> str:
    """Return a node's name with its namespace: hqp_controller, cell1/hqp_controller."""
    return node.get_fully_qualified_name().removeprefix("/")


class Diagnostics:
    """Publishes a node's health to /diagnostics."""

    def __init__(self, node: Node, health: Callable[[], Health], period: float = 1.0) -> None:
        """Ask ``health`` every ``period`` seconds of wall time."""
        self._node = node
        self._health = health
        self._period = period
        self._reported = time.monotonic()
        self._publisher = node.create_publisher(DiagnosticArray, "diagnostics", 10)
        node.create_timer(period, self._publish, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def catch_up(self) -> None:
        """Publish if that is overdue: a timer that is late itself may keep others from coming."""
        if time.monotonic() - self._reported > 1.5 * self._period:
            self._publish()

    def _publish(self) -> None:
        """Publish once."""
        self._reported = time.monotonic()
        health = self._health()
        status = DiagnosticStatus(
            level=health.level,
            name=full_name(self._node),
            message=brief(all_of(health.error, health.message)) or "ok",
            hardware_id=OURS,
            values=[KeyValue(key=key, value=brief(value)) for key, value in health.values.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
