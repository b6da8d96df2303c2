"""Whether a source's chi is of the tick that it names, by the residual of level 1 at that tick."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np

from lexstack.compiled import kernel
from lexstack.transition.messages import SourceSample
from lexstack.types import LinearTask

Rows = tuple[LinearTask, ...]
_FLOAT = np.dtype(np.float64)
_ROUNDING = 1e-6  # relative and absolute, of the norm of level 1's residual


@dataclass(slots=True)
class _Seen:
    """What is known of one transition."""

    # Level 1 of the controller's last ticks, and the revision of the references it was made with.
    levels: dict[int, tuple[Rows, int | None]] = field(default_factory=dict)
    clear: int = 0  # chi of earlier ticks may have other references
    judged: int = -1  # the last tick whose chi was compared
    misses: int = 0  # of the last chi, one after another
    miss: float = 0.0  # of the last one


class ResidualCheck:
    """Compares the level-1 residual of a chi with the one that its source reports.

    Controller and source linearise level 1 at the same state, so both residuals must have the same
    norm, unless the chi is of another tick, as that of a source that is frozen.
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

    def miss(
        self,
        sample: SourceSample,
        tick: int,
        level: Rows,
        *,
        anew: bool = False,
        revision: int | None = None,
    ) -> float:
        """Return by how much a chi's level-1 residual is off the reported one; 0: as far as known.

        A chi is compared with the rows of its tick if both were made with the same revision of the
        references. Where a revision is not known, or is another one, the chi is compared only
        ``memory`` ticks after the references changed: by then the source must have the new ones.

        Args:
            sample: the newest chi of a transition.
            tick: the present one.
            level: level 1 at this tick; empty: there is nothing to compare with.
            anew: whether other references are in effect than at the tick before.
            revision: of the references with which ``level`` was made; None: not known.
        """
        if not level:
            return 0.0
        seen = self._seen.setdefault(sample.transition_id, _Seen())
        levels, oldest = seen.levels, tick - self._memory
        for at in [at for at in levels if not oldest <= at < tick]:
            del levels[at]
        levels[tick] = level, revision
        if anew:
            seen.clear = tick + self._memory
            # Chi that are known to have the old references stay evidence.
            seen.misses = 0 if None in (revision, sample.revision) else seen.misses
        then = levels.get(sample.tick)
        if then is None or sample.tick == seen.judged:
            return seen.miss if seen.misses >= self._patience else 0.0
        same = sample.revision is not None and sample.revision == then[1]
        if same or sample.tick >= seen.clear:
            seen.judged, seen.miss = sample.tick, _miss(sample, then[0])
            seen.misses = seen.misses + 1 if seen.miss else 0
        return seen.miss if seen.misses >= self._patience else 0.0


def _miss(sample: SourceSample, level: Rows) -> float:
    """Return | |level 1 at chi| - slack |, or 0 where that is rounding or not known."""
    if sample.slack is None:
        return 0.0
    residual, fast = 0.0, kernel("lexstack.tasks.kernel.residual")
    for task in level:
        if fast is not None and task.matrix.dtype is task.lower.dtype is task.upper.dtype is _FLOAT:
            residual += fast.square(task.matrix, task.lower, task.upper, sample.chi)
        else:
            rows = task.residual(sample.chi)
            residual += float(rows.dot(rows))
    miss = abs(math.sqrt(residual) - sample.slack)
    return 0.0 if miss <= _ROUNDING * (1.0 + sample.slack) else miss
