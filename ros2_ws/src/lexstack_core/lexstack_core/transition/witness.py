"""Whether a source's chi is of the tick that it names: A knows level 1 of that tick too."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field

from lexstack_core.linear import LinearTask
from lexstack_core.transition.status import SourceSample

Rows = tuple[LinearTask, ...]
_ROUNDING = 1e-6  # relative and absolute, of the norm of level 1's residual


@dataclass(slots=True)
class _Seen:
    """What is known of one transition."""

    levels: dict[int, Rows] = field(default_factory=dict)  # level 1 of A's last ticks
    clear: int = 0  # chi of earlier ticks are no evidence: they may have other references
    judged: int = -1  # the last tick whose chi was compared
    misses: int = 0  # of the last chi, one after another
    miss: float = 0.0  # of the last one


class Witness:
    """Compares what a chi leaves of level 1 with what its source says of it.

    A and its source linearise level 1 at the same state: the same norm must come out, unless the
    chi is of another tick, as of a source that is frozen.
    """

    def __init__(self, memory: int, patience: int) -> None:
        """Start without evidence.

        Args:
            memory: so many ticks a chi may be late.
            patience: so many chi in a row must miss.
        """
        self._memory = memory
        self._patience = patience
        self._seen: dict[int, _Seen] = {}

    def keep(self, transition_ids: Collection[int]) -> None:
        """Forget all other transitions."""
        self._seen = {id_: seen for id_, seen in self._seen.items() if id_ in transition_ids}

    def miss(self, sample: SourceSample, tick: int, level: Rows, *, anew: bool = False) -> float:
        """Return by how much a source's chi misses what it says of level 1; 0: as far as known.

        Args:
            sample: the newest chi of a transition.
            tick: the present one.
            level: level 1 at this tick; empty: there is nothing to compare with.
            anew: whether the references are others than at the tick before. Where chi may be late,
                they may have reached its source some ticks before or later: that is no evidence.
        """
        if not level:
            return 0.0
        seen = self._seen.setdefault(sample.transition_id, _Seen())
        seen.levels = {
            at: rows for at, rows in seen.levels.items() if tick - self._memory <= at < tick
        }
        seen.levels[tick] = level
        if anew:
            seen.clear, seen.misses = tick + self._memory, 0
        then = seen.levels.get(sample.tick)
        if then is not None and sample.tick >= seen.clear and sample.tick != seen.judged:
            seen.judged, seen.miss = sample.tick, _miss(sample, then)
            seen.misses = seen.misses + 1 if seen.miss else 0
        return seen.miss if seen.misses >= self._patience else 0.0


def _miss(sample: SourceSample, level: Rows) -> float:
    """Return | |level 1 at chi| - slack |, or 0 where that is rounding or not known."""
    if sample.slack is None:
        return 0.0
    residual = sum(float(r.dot(r)) for r in (task.residual(sample.chi) for task in level))
    miss = abs(math.sqrt(residual) - sample.slack)
    return 0.0 if miss <= _ROUNDING * (1.0 + sample.slack) else miss
