"""What became of the sequences that the HTMPC executed: which task was done when, and how well."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc import SequenceTask
from lexstack_bag.run.run import PlanTopics, ProgressStream, Run

STEADY_WINDOW = 0.5  # s, before a task is done, over which its error is averaged
_BEGINNINGS = ("begin", "replace")
_MM = 1e3


@dataclass(frozen=True, slots=True)
class TaskTime:
    """One task while it was the first one that was not done."""

    name: str
    first_s: float  # s, since when it was the first one
    done_s: float | None  # s; None: not done
    error_mm: float | None  # of its goal, mean over the last STEADY_WINDOW before it was done
    error_mrad: float | None = None  # likewise; 0 where a task has no angles
    moves: str = ""  # what: a frame, the base or joints; empty: the bag does not say


@dataclass(frozen=True, slots=True)
class SequenceMetrics:
    """The figures of one sequence; times are simulated."""

    robot: str
    architecture: str  # ht or st
    begun_s: float
    end_s: float  # of its last plan
    completion_s: float | None  # from begun_s until all tasks were done; None: they were not
    done: int
    count: int  # of its tasks
    plans_hz: float | None
    failed_plans: int
    level_error_mm: dict[str, float | None]  # mean distance from the reference, by level
    tasks: tuple[TaskTime, ...]
    cancelled: bool = False  # by a user, before all its tasks were done

    @property
    def title(self) -> str:
        """The sequence in words."""
        return f"{self.robot}, {self.architecture.upper()}-Arch"


def sequences_of(run: Run) -> tuple[SequenceMetrics, ...]:
    """Return the sequences in the order in which they began."""
    found = [
        _figures(robot, plan_topics, rows)
        for robot, plan_topics in run.plan_topics.items()
        for rows in executions(plan_topics)
    ]
    return tuple(sorted(found, key=lambda one: (one.begun_s, run.robots.index(one.robot))))


def executions(plan_topics: PlanTopics) -> Iterator[NDArray[np.int64]]:
    """Yield for every sequence the rows of its progress."""
    ticks = plan_topics.progress.tick
    begins = [event.tick for event in plan_topics.events if event.event in _BEGINNINGS]
    # What a bag holds of a sequence that began before it is one too.
    edges = [-1, *begins, np.iinfo(np.int64).max]
    for first, last in pairwise(edges):
        rows = np.flatnonzero((ticks >= first) & (ticks < last))
        if len(rows):
            yield rows


def ratio_of(sequences: Sequence[SequenceMetrics]) -> float | None:
    """Return the time of ST-Arch over that of HT-Arch for the same number of tasks.

    None unless the run has one sequence of each, and both were completed.
    """
    times = {
        name: [one for one in sequences if one.architecture == name and one.completion_s]
        for name in ("ht", "st")
    }
    if len(sequences) != 2 or any(len(found) != 1 for found in times.values()):
        return None
    (ht,), (st,) = times["ht"], times["st"]
    if ht.count != st.count or not ht.completion_s or not st.completion_s:
        return None
    return st.completion_s / ht.completion_s


def goals_in(plan_topics: PlanTopics) -> dict[str, SequenceTask]:
    """Return all tasks of a robot's sequences as they were last, by name."""
    return {task.name: task for event in plan_topics.events for task in event.tasks}


def _is_cancelled(plan_topics: PlanTopics, rows: NDArray[np.int64]) -> bool:
    """Return whether a user cancelled the sequence that these rows of progress are about."""
    first = int(plan_topics.progress.tick[rows[0]])
    begins = [e.tick for e in plan_topics.events if e.event in _BEGINNINGS and e.tick > first]
    end = min(begins, default=np.iinfo(np.int64).max)
    return any(e.event == "cancel" and first <= e.tick < end for e in plan_topics.events)


def _figures(robot: str, plan_topics: PlanTopics, rows: NDArray[np.int64]) -> SequenceMetrics:
    """Return the figures of one sequence."""
    progress = plan_topics.progress
    first, last = rows[0], rows[-1]
    under_way = rows[progress.index[rows] < progress.count[rows]]
    over = rows[progress.index[rows] >= progress.count[rows]]
    begun = float(progress.stamp[first])
    errors = _MM * np.asarray(progress.errors)[under_way]
    steps = np.diff(progress.stamp[rows])
    return SequenceMetrics(
        robot,
        str(progress.architecture[first]),
        begun,
        float(progress.stamp[last]),
        float(progress.stamp[over[0]]) - begun if len(over) else None,
        int(progress.index[last]),
        int(progress.count[last]),
        float(1.0 / np.median(steps)) if len(steps) else None,
        int(np.count_nonzero(progress.solved[rows] == 0)),
        {
            f"level {level + 1}": float(np.nanmean(column))
            for level, column in enumerate(errors.T)
            if np.isfinite(column).any()
        },
        tuple(_tasks(progress, rows, goals_in(plan_topics))),
        not len(over) and _is_cancelled(plan_topics, rows),
    )


def _tasks(
    progress: ProgressStream, rows: NDArray[np.int64], goals: Mapping[str, SequenceTask]
) -> Iterator[TaskTime]:
    """Yield the tasks in the order in which they were first."""
    index = progress.index[rows]
    edges = [0, *(np.flatnonzero(np.diff(index)) + 1).tolist()]
    for place, begin in enumerate(edges):
        if index[begin] >= progress.count[rows[begin]]:
            return
        done = place + 1 < len(edges)
        end = edges[place + 1] if done else len(rows)
        mine = rows[begin:end]
        stop = float(progress.stamp[rows[end]]) if done else None
        error = angle = None
        if stop is not None:
            late = mine[progress.stamp[mine] >= stop - STEADY_WINDOW - 1e-6]
            if len(late):
                error = float(_MM * progress.error[late].mean())
                angle = float(_MM * progress.error_angle[late].mean())
        name = str(progress.task[mine[-1]])
        moves = moved_by(goals[name]) if name in goals else ""
        yield TaskTime(name, float(progress.stamp[mine[0]]), stop, error, angle, moves)


def moved_by(task: SequenceTask) -> str:
    """Return what a task moves, in words: a frame, the base, or joints."""
    if task.kind == "joint_positions":
        return ", ".join(task.joints) or "all joints"
    return task.frame if task.kind.startswith("ee") else "base"
