"""The order of ticks: what is new, what is over, and what cannot be true."""

from __future__ import annotations

import time
from collections.abc import Callable

from lexstack.errors import InputError

_FASTEST = 2000.0  # ticks per second of wall time; lockstep reaches some hundred
_SLACK = 5  # ticks


class TickOrder:
    """Tells new states from repeated, replayed and impossible ones.

    A tick is ahead of the last by as much as time has passed: a process that was stopped for a
    while finds the present again, and a state of the far future is not believed.

    Attributes:
        begins_anew: whether the last new state is the first after a reset of the plant, or of
            another plant.
    """

    def __init__(self, where: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin before the first tick of the topic ``where``; ``clock`` is monotonic [s]."""
        self.begins_anew = False
        self._where = where
        self._clock = clock
        self._origin: tuple[str, int] | None = None  # sender, resets
        self._last = -1
        self._heard = self._sent = 0.0

    def is_new(self, sender: str, resets: int, tick: int, sent: float = 0.0) -> bool:
        """Return whether a state is to be served: false when it is over already.

        A process that stood still takes what has waited all at once. So the time from one state to
        the next is the longer one of two: that on this clock, and that between their sendings
        (``sent``, s by the sender's clock, as the middleware has it).

        Raises:
            InputError: it is farther ahead of the last one than time allows.
        """
        self.begins_anew = False
        now = self._clock()
        if self._origin is None or sender != self._origin[0] or resets > self._origin[1]:
            self.begins_anew = self._origin is not None
            self._origin = (sender, resets)
        elif resets < self._origin[1] or tick <= self._last:
            return False
        elif tick - self._last > _SLACK + _FASTEST * max(now - self._heard, sent - self._sent):
            raise InputError(f"{self._where}: tick: {tick} cannot follow {self._last} so soon")
        self._last, self._heard, self._sent = tick, now, sent
        return True
