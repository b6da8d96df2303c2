"""The time of real robots: the wall's, or a simulator's, which /clock tells."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic, time_ns

from builtin_interfaces.msg import Time
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from lexstack_plant.hardware.messages import seconds_of
from lexstack_ros.intake.drain import waiting
from lexstack_ros.messages.conversions import to_time
from lexstack_ros.messages.qos import STREAM

_BACK = 0.01  # s, by which a simulator's time goes back where it begins again
_SET = 0.005  # s: a clock that is off by so much has been set
_QUICK = 1e-4  # s, for looking at two clocks; longer: the process was interrupted meanwhile


class WallClock:
    """Monotonic time; stamps are those of the wall, since 1970.

    Two stamps differ by as much as their times, to a nanosecond: drives at 1 kHz would feel a
    trajectory that is shifted by a microsecond. So the difference of the two clocks is kept; both
    are slewed together, and only a wall that is set changes it.
    """

    def __init__(
        self,
        monotonic: Callable[[], float] = monotonic,
        wall: Callable[[], int] = time_ns,
    ) -> None:
        """Look at both clocks, which return s and ns."""
        self._monotonic, self._wall = monotonic, wall
        self._offset = self._difference()[0]

    def now(self) -> float:
        """Return the time [s]."""
        return self._monotonic()

    def stamp(self, due: float) -> Time:
        """Return the stamp of a time [s]."""
        offset, took = self._difference()
        if took < _QUICK and abs(offset - self._offset) > 1e9 * _SET:
            self._offset = offset
        stamp = self._offset + round(1e9 * due)
        return Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)

    def _difference(self) -> tuple[int, float]:
        """Return wall's time - monotonic time [ns], and how long looking at them took [s]."""
        before = self._monotonic()
        wall = self._wall()
        after = self._monotonic()
        return wall - round(0.5e9 * (before + after)), after - before


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

    def stamp(self, due: float) -> Time:
        """Return the stamp of a time [s]: they are the same."""
        return to_time(due)

    def _hear(self, message: Clock) -> None:
        """Take the time; a simulator that was reset begins again, and its robots are elsewhere."""
        for newest in (message, *(other for other, _ in waiting(self._clock))):
            before, self._now = self._now, seconds_of(newest.clock)
            if before - self._now > _BACK:
                self._on_back(before - self._now)
        self._on_time()


HardwareClock = WallClock | SimulatedClock
