"""What may become of the solver's messages to the controller: late, lost, or frozen."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from lexstack.transition import SourceSample


class Delayed:
    """Every message arrives a number of ticks late."""

    def __init__(self, ticks: int) -> None:
        """Start with nothing on its way; ``ticks`` is the delay."""
        self._ticks = ticks
        self._coming: deque[SourceSample] = deque()

    def __call__(self, sample: SourceSample) -> SourceSample | None:
        """Take a message in, and give out the one that arrives at the same tick, if any."""
        self._coming.append(sample)
        due = sample.tick - self._ticks
        while self._coming and self._coming[0].tick < due:
            self._coming.popleft()
        return self._coming.popleft() if self._coming and self._coming[0].tick == due else None


class Lost:
    """From a tick on nothing arrives."""

    def __init__(self, tick: int) -> None:
        """Lose what is sent at ``tick`` and later."""
        self._tick = tick

    def __call__(self, sample: SourceSample) -> SourceSample | None:
        """Let a message through, or lose it."""
        return sample if sample.tick < self._tick else None


class Frozen:
    """From a tick on the last chi arrives again and again, as if it were new."""

    def __init__(self, tick: int) -> None:
        """Freeze the chi that is sent last before ``tick``."""
        self._tick = tick
        self._last: SourceSample | None = None

    def __call__(self, sample: SourceSample) -> SourceSample | None:
        """Let a message through, or put the frozen chi in its place."""
        if sample.tick < self._tick:
            self._last = sample
        if self._last is None:
            return sample
        return replace(sample, chi=self._last.chi, slack=self._last.slack)
