"""How old messages are when they come, and what that says of the clocks of two hosts.

Nothing waits or decides by wall-clock stamps: ticks pair the messages, and waits use the
monotonic clock of one host. A clock that is off is told, nothing else.
"""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable
from typing import Any

_SILENT = 2.5  # s of wall time: a bridge in lockstep may wait for a command for 2 s
_TOLERATED = 0.01  # s: a delay beyond what a local network needs is a clock that is off
# Of the time from message to message: a host that is too slow to keep its ticks, or that is told to
# simulate slowly, delivers its messages late too, and there are few of them to find the least of.
_SHARE = 0.1


class Delays:
    """The delays of one topic's messages since the last report.

    The smallest delay is the offset of the receiver's clock from the sender's plus the fastest
    transport, which a network does in less than a millisecond. So a negative one, or one of many
    milliseconds in every message, is the clocks'. How many depends on the period of the messages
    as it really is; one message alone says nothing.

    Attributes:
        silent: whether no message had come for a while, 2.5 s, at the last report.
    """

    def __init__(self, where: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin for the topic ``where``; ``clock`` is monotonic [s]."""
        self._where = where
        self._clock = clock
        self.silent = False
        self._smallest: float | None = None
        self._heard: float | None = None
        self._counted = 0  # periods since the last report
        self._since: float | None = None  # when the first of them began

    def add(self, info: dict[str, int]) -> None:
        """Take the info of one message, as rclpy hands it over."""
        delay = 1e-9 * (info["received_timestamp"] - info["source_timestamp"])
        self._smallest = delay if self._smallest is None else min(self._smallest, delay)
        self._counted += self._heard is not None
        self._heard = self._clock()
        self._since = self._heard if self._since is None else self._since

    def report(self) -> tuple[str, dict[str, str]]:
        """Return a complaint (or '') and the figures since the last report."""
        smallest, self._smallest = self._smallest, None
        tolerated = max(_TOLERATED, _SHARE * self._period())
        age = float("inf") if self._heard is None else self._clock() - self._heard
        values = {f"age of the last {self._where} [ms]": f"{1e3 * age:.0f}"}
        self.silent = age > _SILENT
        if self.silent:
            return f"{self._where} is silent", values
        if smallest is None:
            return "", values
        values[f"least delay of {self._where} [ms]"] = f"{1e3 * smallest:.1f}"
        # Nothing comes before it was sent: a negative delay needs no allowance.
        if -_TOLERATED <= smallest <= tolerated:
            return "", values
        who = "behind" if smallest < 0.0 else "ahead of"
        off = f"{1e3 * abs(smallest):.0f} ms {who} that of the sender of {self._where}"
        return f"this host's clock is {off}", values

    def _period(self) -> float:
        """Return the mean time from message to message since the last report [s], and forget it."""
        heard, since, counted = self._heard, self._since, self._counted
        self._since, self._counted = heard, 0
        if heard is None or since is None or not counted:
            return float("inf")
        return (heard - since) / counted


def with_info(take: Callable[[Any, dict[str, Any]], None]) -> Callable[..., None]:
    """Return ``take`` as a callback that works with every executor of rclpy.

    EventsExecutor hands message and info over as one tuple, the other executors as two
    arguments; both look at the signature to see whether the info is wanted.
    """

    def callback(*arguments: Any) -> None:
        take(*(arguments[0] if len(arguments) == 1 else arguments))

    callback.__signature__ = inspect.signature(take)  # type: ignore[attr-defined]
    return callback
