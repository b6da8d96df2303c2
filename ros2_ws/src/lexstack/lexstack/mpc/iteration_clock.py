"""Whether a solve has time for one more iteration: asked before each one."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter


class IterationClock:
    """The time that a solve has, and how long its iterations take.

    An iteration is begun where the longest one so far would still fit. The first one always is: a
    plan without any would be the plan before.
    """

    def __init__(self, deadline: float = 0.0, clock: Callable[[], float] = perf_counter) -> None:
        """Begin now, with a deadline in s of the clock; 0: as long as it takes."""
        self._deadline = deadline
        self._clock = clock
        self._begun = self._last = clock() if deadline else 0.0
        self._longest = 0.0
        self._iterations = 0

    def enough(self) -> bool:
        """Return whether there is time for one more iteration, which begins now."""
        if not self._deadline:
            return True
        self._last = self._clock()
        left = self._begun + self._deadline - self._last
        return not self._iterations or left >= self._longest

    def done(self) -> None:
        """Tell that an iteration has ended."""
        if self._deadline:
            self._iterations += 1
            self._longest = max(self._longest, self._clock() - self._last)
