"""The time of real robots: the wall's, or a simulator's, which /clock tells."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic, time

from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from lexstack_plant.hardware.messages import seconds_of
from lexstack_ros.intake.drain import waiting
from lexstack_ros.messages.qos import STREAM

_BACK = 0.01  # s, by which a simulator's time goes back where it begins again


class WallClock:
    """Monotonic time; stamps are seconds since 1970."""

    def now(self) -> float:
        """Return the time [s]."""
        return monotonic()

    def stamp(self, due: float) -> float:
        """Return the stamp of a time [s]."""
        return time() + due - monotonic()


class SimulatedClock:
    """The time of /clock, which stands still and goes slowly where the simulator does."""

    def __init__(
        self, node: Node, on_time: Callable[[], None], on_back: Callable[[float], None]
    ) -> None:
        """Listen to /clock.

        ``on_time`` is called whenever the time has changed, ``on_back`` before where it went back,
        with by how much [s].
        """
        self._now = 0.0
        self._on_time, self._on_back = on_time, on_back
        self._clock = node.create_subscription(Clock, "clock", self._hear, STREAM)

    def now(self) -> float:
        """Return the time [s]; 0 before the first message."""
        return self._now

    def stamp(self, due: float) -> float:
        """Return the stamp of a time [s]: they are the same."""
        return due

    def _hear(self, message: Clock) -> None:
        """Take the time; a simulator that was reset begins again, and its robots are elsewhere."""
        for newest in (message, *(other for other, _ in waiting(self._clock))):
            before, self._now = self._now, seconds_of(newest.clock)
            if before - self._now > _BACK:
                self._on_back(before - self._now)
        self._on_time()


HardwareClock = WallClock | SimulatedClock
