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
        self._partial: dict[int, list[SourceSample]] = {}
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
        before = self._partial.get(sample.transition_id, [])
        samples = [
            other
            for other in before
            if _age(other) == age and not set(other.robots or ()) & set(sample.robots)
        ]
        samples.append(sample)
        self._partial[sample.transition_id] = samples
        if not set(needed) <= {robot for other in samples for robot in other.robots or ()}:
            return None
        del self._partial[sample.transition_id]
        return self._joined(samples)

    def keep(self, transition_ids: Collection[int]) -> None:
        """Forget all other transitions."""
        self._partial = {
            id_: samples for id_, samples in self._partial.items() if id_ in transition_ids
        }
        self._newest = {id_: tick for id_, tick in self._newest.items() if id_ in transition_ids}

    def _joined(self, samples: list[SourceSample]) -> SourceSample:
        """Return parts side by side: residuals as one vector, solved where all are."""
        chi = np.zeros(self._team.n)
        for other in samples:
            columns = self._team.columns(other.robots or ())
            chi[columns] = other.chi[columns]
        chi.setflags(write=False)
        slacks = [other.slack for other in samples]
        slack = None
        if None not in slacks:
            slack = math.hypot(*(value for value in slacks if value is not None))
        solved = all(other.solved for other in samples)
        return replace(samples[0], chi=chi, solved=solved, slack=slack, robots=None)


def _age(other: SourceSample) -> tuple[int, int]:
    """Return the tick and the references' revision of a part; parts that differ do not fit."""
    return other.tick, -1 if other.revision is None else other.revision
