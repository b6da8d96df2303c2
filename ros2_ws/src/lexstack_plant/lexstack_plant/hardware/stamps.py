"""Which messages of a topic are new, by their stamps, and when they were measured."""

from __future__ import annotations

import numpy as np

from lexstack_plant.hardware.joint_intake import IntakeCounters
from lexstack_plant.hardware.sender_clock import SenderClock, set_back


class Stamps:
    """The stamps of one topic's messages."""

    def __init__(self, *, shared: bool) -> None:
        """Begin without messages; ``shared``: stamps are of the local clock."""
        self._clock = SenderClock(shared=shared)
        self._newest = -np.inf

    def restarted(self, stamp: float) -> str:
        """Return that the sender's clock was set back, as a fault, or ''; all before is forgotten.

        To be called before ``time``.
        """
        fault = set_back(stamp, self._newest)
        if fault:
            self._newest = -np.inf
            self._clock.forget()
        return fault

    def time(self, stamp: float, received: float, counters: IntakeCounters) -> float | None:
        """Return when a message was measured, or None if it is not newer than those before.

        Args:
            stamp: s by the sender's clock; 0: none, then its arrival counts.
            received: s by the local clock.
            counters: that a message which is not new is counted in.
        """
        if not stamp:
            return received
        if stamp <= self._newest:
            repeated = stamp == self._newest
            counters.repeated += repeated
            counters.late += not repeated
            return None
        self._newest = stamp
        return self._clock.local(stamp, received)
