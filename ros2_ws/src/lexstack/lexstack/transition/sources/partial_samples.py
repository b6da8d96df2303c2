"""One chi from several solvers: each solves the stack of some robots, for the same tick."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from lexstack.robots import Team
from lexstack.transition.messages import SourceSample


class PartialSampleMerger:
    """Keeps parts until, of one tick and transition, all robots of the stack are there."""

    def __init__(self, team: Team) -> None:
        """Join chi of this team."""
        self._team = team
        # By transition, all of one tick and one revision of the references.
        self._parts: dict[int, list[SourceSample]] = {}
        self._newest: dict[int, tuple[int, int]] = {}  # tick and revision, by transition

    def join(self, sample: SourceSample, needed: Collection[int]) -> SourceSample | None:
        """Return the chi of all ``needed`` robots, or None while parts of it are missing.

        Args:
            sample: of all robots (then it is returned), or of some: the others' joints are 0.
            needed: places of the robots that the stack moves.
        """
        if sample.robots is None or set(needed) <= set(sample.robots):
            return sample
        age = _age(sample)
        if age < self._newest.get(sample.transition_id, age):
            return None  # a part of the past
        self._newest[sample.transition_id] = age
        before = self._parts.get(sample.transition_id, [])
        parts = [
            part
            for part in before
            if _age(part) == age and not set(part.robots or ()) & set(sample.robots)
        ]
        parts.append(sample)
        self._parts[sample.transition_id] = parts
        if not set(needed) <= {robot for part in parts for robot in part.robots or ()}:
            return None
        del self._parts[sample.transition_id]
        return self._joined(parts)

    def keep(self, transition_ids: Collection[int]) -> None:
        """Forget all other transitions."""
        self._parts = {id_: parts for id_, parts in self._parts.items() if id_ in transition_ids}
        self._newest = {id_: tick for id_, tick in self._newest.items() if id_ in transition_ids}

    def _joined(self, parts: list[SourceSample]) -> SourceSample:
        """Return parts side by side: residuals as one vector, solved where all are."""
        chi = np.zeros(self._team.n)
        for part in parts:
            columns = self._team.columns(part.robots or ())
            chi[columns] = part.chi[columns]
        chi.setflags(write=False)
        slacks = [part.slack for part in parts]
        slack = None
        if None not in slacks:
            slack = math.hypot(*(value for value in slacks if value is not None))
        solved = all(part.solved for part in parts)
        return replace(parts[0], chi=chi, solved=solved, slack=slack, robots=None)


def _age(part: SourceSample) -> tuple[int, int]:
    """Return the tick and the references' revision of a part; parts that differ do not fit."""
    return part.tick, -1 if part.revision is None else part.revision
