"""From the stamps of a sender to this process's clock, whatever the delay of each message."""

from __future__ import annotations

from collections import deque

# s: no message is that much older than the newest one. Its sender began anew, or its clock was
# corrected.
_SET_BACK = 1.0
_WINDOW = 5.0  # s, over which the least delay is looked for: clocks drift by less than 0.1 ms in it


class SenderClock:
    """Maps stamps to local time by the least delay of the last messages.

    A message arrives after it was sent: local - stamp is the offset of the two clocks plus a delay
    that is never negative. Its least value over some seconds is the offset and the fastest
    transport, so a late message has its true age, and jitter of the transport has no effect.
    """

    def __init__(self, *, shared: bool = False) -> None:
        """Begin without messages; ``shared``: stamps are of our own clock, as in simulated time.

        There the time that we know may lag behind the stamps, and then a least delay would be
        wrong by that for as long as the window lasts.
        """
        self._shared = shared
        # Differences in increasing order, with the times at which they came: the first is the
        # least one of the window, the others those that will be the least once it is over.
        self._least: deque[tuple[float, float]] = deque()

    def forget(self) -> None:
        """Begin without messages: the sender's clock is another one."""
        self._least.clear()

    def local(self, stamp: float, received: float) -> float:
        """Return when a message was stamped [s], by the local clock."""
        if self._shared:
            return stamp
        difference = received - stamp
        while self._least and self._least[-1][1] >= difference:
            self._least.pop()
        self._least.append((received, difference))
        while self._least[0][0] < received - _WINDOW:
            self._least.popleft()
        return stamp + self._least[0][1]


def set_back(stamp: float, newest: float) -> str:
    """Return that a sender's clock was set back, as a fault, or ''.

    Without this all its messages would count as late until the clock is where it was.

    Args:
        stamp: of a message [s]; 0: it has none.
        newest: of those before [s]; -inf: there was none.
    """
    if not stamp or newest - stamp <= _SET_BACK:
        return ""
    return f"the clock of its messages was set back by {newest - stamp:.3g} s"
