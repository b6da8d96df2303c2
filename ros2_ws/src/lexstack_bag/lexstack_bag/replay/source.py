"""The solver's recorded answers, as the controller took them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lexstack.robots import Team
from lexstack.transition import SourceSample
from lexstack_bag.replay.states import Arrivals, all_of
from lexstack_bag.run.partial_chi import robots_of
from lexstack_bag.run.run import ChiStream, Run, SolveStatus

SOLVER = "robot_b"
"""Whose chi the solver sends."""


def heard_samples(run: Run, team: Team) -> Arrivals[SourceSample]:
    """Return the solver's answers as the controller took them, by the time of their sending."""
    return Arrivals(list(_each(all_of(run, SOLVER), team)))


def revision_of(chi: ChiStream, row: int) -> int | None:
    """Return the revision of the references that the solver used, None where it is not known."""
    known = int(chi.references[row]) if len(chi.references) else 0
    return known or None


def _slack(chi: ChiStream, row: int) -> float | None:
    """Return what the solver said of level 1, None where it said nothing."""
    known = chi.slacks.shape[1] > 0 and bool(np.isfinite(chi.slacks[row, 0]))
    return float(chi.slacks[row, 0]) if known else None


def _each(chi: ChiStream, team: Team) -> Iterator[tuple[int, SourceSample]]:
    """Yield the solver's messages as the controller took them, and when they were sent [ns]."""
    for row in range(len(chi.tick)):
        robots = robots_of(str(chi.robots[row]), team)
        some = len(robots) < len(team.names)
        values = chi.chi[row]
        if some:
            values, columns = np.zeros(team.n), team.columns(robots)
            values[columns] = chi.chi[row, columns]
        if np.isnan(values).any():
            continue  # A refused it
        yield (
            int(chi.sent[row]),
            SourceSample(
                int(chi.transition_id[row]),
                int(chi.tick[row]),
                values,
                int(chi.status[row]) == SolveStatus.SOLVED,
                _slack(chi, row),
                robots if some else None,
                str(chi.stack[row]),
                revision_of(chi, row),
            ),
        )
