"""How far the stand-in falls behind the wall's clock: this machine's fault, not its robots'."""

from __future__ import annotations

from dataclasses import dataclass

LATE = 0.03
"""s behind the clock that count as late: some periods of the states."""


@dataclass(slots=True)
class Lateness:
    """What a process counted that should be in time.

    Attributes:
        looks: how often the robots were moved up to the clock.
        late: how often they were behind it by more than ``LATE`` by then.
        longest: by how much at most [s].
        newest: by how much at most since the last report [s].
    """

    looks: int = 0
    late: int = 0
    longest: float = 0.0
    newest: float = 0.0

    def add(self, behind: float) -> None:
        """Take note of how far the robots are behind the clock [s], before they are moved."""
        self.looks += 1
        self.late += behind > LATE
        self.longest = max(self.longest, behind)
        self.newest = max(self.newest, behind)

    def report(self) -> tuple[str, float]:
        """Return a complaint, or '', and the largest lateness since the last report [s]."""
        newest, self.newest = self.newest, 0.0
        if newest <= LATE:
            return "", newest
        return f"{1e3 * newest:.0f} ms behind the clock: the machine is busy", newest

    def __str__(self) -> str:
        """Return all of it in one line."""
        return (
            f"behind the clock by more than {1e3 * LATE:.0f} ms at {self.late} of {self.looks} "
            f"looks, at most {1e3 * self.longest:.0f} ms"
        )
