"""The lines between robots and whoever commands them: messages come late, or never."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator
from typing import Generic, TypeVar

import numpy as np

from lexstack_testing.stand_in.habits import Habits

T = TypeVar("T")


class Lines(Generic[T]):
    """Messages on their way. None overtakes another one on its line."""

    def __init__(self, habits: Habits, random: np.random.Generator) -> None:
        """Carry nothing yet; ``random`` decides what becomes of each message."""
        self._habits, self._random = habits, random
        self._coming: list[tuple[float, int, T]] = []
        self._count = itertools.count()
        self._arrival: dict[tuple[str, str], float] = {}  # of the last message of each line

    def send(self, line: tuple[str, str], message: T, now: float) -> None:
        """Put a message on its way at ``now`` [s], late by jitter or more, or lose it."""
        habits = self._habits
        chance, lateness = self._random.random(2)
        if chance < habits.drop:
            return
        delay = habits.jitter * lateness
        if chance < habits.drop + habits.late:
            delay += habits.late_by
        # One that is late holds up those behind it.
        arrives = max(now + delay, self._arrival.get(line, -np.inf))
        self._arrival[line] = arrives
        heapq.heappush(self._coming, (arrives, next(self._count), message))

    def arrived(self, now: float) -> Iterator[tuple[float, T]]:
        """Take out the messages that have arrived by ``now`` [s], each with when, in order."""
        while self._coming and self._coming[0][0] <= now:
            arrives, _, message = heapq.heappop(self._coming)
            yield arrives, message
