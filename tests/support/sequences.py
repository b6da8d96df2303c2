"""Sequences of tasks as a bag tells of them, made by hand."""

from __future__ import annotations

import numpy as np

from lexstack.mpc import SequenceTask
from lexstack_bag.run.run import PlanStream, PlanTopics, ProgressStream, SequenceEvent

EVERY = 5
TO = SequenceTask("to", "base_position", ((1.0, 0.5),))
GIVE = SequenceTask("give", "ee_position", ((1.5, 0.5, 1.0),))


def progress(spans, architecture="ht", first=20):
    """Return the progress of tasks that were the first ones for so many plans."""
    names = [name for name, plans in spans for _ in range(plans)]
    index = np.repeat(np.arange(len(spans)), [plans for _, plans in spans])
    count = len(names)
    ticks = first + EVERY * np.arange(count)
    errors = np.linspace(0.1, 0.0, count)
    return ProgressStream(
        ticks,
        0.01 * ticks,
        np.array([architecture] * count, dtype=object),
        index,
        np.full(count, len({name for name, _ in spans if name})),
        np.array([name or spans[-2][0] for name in names], dtype=object),
        errors,
        np.zeros(count),
        np.column_stack((np.full(count, 0.002), np.full(count, 0.03))),
        np.ones(count, np.int64),
        np.full(count, 0.004),
    )


def plan_topics(spans, architecture="ht", first=20, events=None):
    """Return what the HTMPC did for a robot; by default the sequence began at the first tick."""
    empty = PlanStream(*(np.zeros(0) for _ in PlanStream.__dataclass_fields__))
    begun = SequenceEvent(1, first, architecture, "begin", "", (TO, GIVE))
    return PlanTopics(empty, progress(spans, architecture, first), tuple(events or (begun,)))
