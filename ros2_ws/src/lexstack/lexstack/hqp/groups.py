"""Robots that tasks couple, and their share of every level: singularities are theirs alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lexstack.hqp.group_level import GroupLevel
from lexstack.hqp.hierarchy import Indices, Mask
from lexstack.hqp.problem import HqpProblem
from lexstack.types import LinearTask, Matrix, Vector

Robots = tuple[int, ...]
Slices = tuple[slice, ...]


@dataclass(frozen=True, slots=True)
class Group:
    """Robots that some task couples, or one that none does.

    Attributes:
        columns: their joints in chi.
        size: how many those are.
        places: of each robot's joints among them.
        ranks: the levels that have tasks of theirs, down to the last one that may need damping.
        tasks: the places of these tasks in each of these levels.
    """

    columns: slice | Indices
    size: int
    places: dict[int, slice]
    ranks: tuple[int, ...]
    tasks: tuple[tuple[int, ...], ...]

    def levels(self, problem: HqpProblem) -> list[GroupLevel]:
        """Return the group's share of a problem, its equality objectives.

        Inequality rows do not count: what they take away is no singularity of the robots.
        """
        found: list[GroupLevel] = []
        nested = False
        for k, chosen in zip(self.ranks, self.tasks, strict=True):
            level = problem.levels[k]
            tasks = tuple([level[place] for place in chosen])
            parts = [self._rows(task) for task in tasks]
            matrix, error = parts[0]
            starts = [0]
            for one, _ in parts[:-1]:
                starts.append(starts[-1] + len(one))
            if len(parts) > 1:
                matrix = np.concatenate([one for one, _ in parts])
                error = np.concatenate([one for _, one in parts])
            curves = [task.curve for task in tasks if task.curve is not None]
            curved = any(curve.signs for curve in curves)
            scale = max([curve.scale for curve in curves], default=1.0)
            found.append(GroupLevel(tasks, matrix, error, scale, curved, nested, tuple(starts)))
            nested = nested or curved
        return found

    def _rows(self, task: LinearTask) -> tuple[Matrix, Vector]:
        """Return a task's rows that ask for something, on the group's joints, and their errors."""
        matrix = task.matrix[:, self.columns]
        if task.curve is not None:
            return matrix, task.correction / task.curve.gain
        asking = _asking(task)
        if asking is None:
            return matrix[:0], np.zeros(0)
        return matrix[asking], np.zeros(int(np.count_nonzero(asking)))


def groups_of(problem: HqpProblem, slices: Slices) -> tuple[Group, ...]:
    """Return the groups of robots for which some level may need damping.

    Args:
        problem: over all joints of a team.
        slices: each robot's part of chi.
    """
    depth = 0
    for k, level in enumerate(problem.levels, start=1):
        if any(task.curve is not None for task in level):
            depth = k
    coupled = tuple(
        [tuple([_robots(task, slices) for task in level]) for level in problem.levels[:depth]]
    )
    return _groups(coupled, tuple([(part.start, part.stop) for part in slices]))


def _robots(task: LinearTask, slices: Slices) -> Robots:
    """Return the robots that a task's equality objectives move."""
    if task.curve is not None:
        return task.curve.robots
    asking = _asking(task)
    if asking is None:
        return ()
    moved = np.flatnonzero(task.matrix[asking].any(axis=0))
    ends = [part.stop for part in slices]
    return tuple(np.unique(np.searchsorted(ends, moved, side="right")).tolist())


def _asking(task: LinearTask) -> Mask | None:
    """Return which rows of a task without a curve are equality objectives; None: none is."""
    if task.upper is task.lower:
        asking = task.matrix.any(axis=1)
    else:
        asking = (task.lower == task.upper) & task.matrix.any(axis=1)
    return np.asarray(asking) if asking.any() else None


@lru_cache(maxsize=64)
def _groups(
    coupled: tuple[tuple[Robots, ...], ...], spans: tuple[tuple[int, int], ...]
) -> tuple[Group, ...]:
    """Return the groups, given the robots of every task of every level."""
    label = list(range(len(spans)))
    for robots in [robots for level in coupled for robots in level if robots]:
        least = min([label[robot] for robot in robots])
        merged = {label[robot] for robot in robots}
        label = [least if one in merged else one for one in label]
    groups = []
    for first in sorted(set(label)):
        robots = tuple([robot for robot, one in enumerate(label) if one == first])
        chosen = [
            (k, tuple([i for i, mine in enumerate(level) if mine and mine[0] in robots]))
            for k, level in enumerate(coupled)
        ]
        chosen = [(k, places) for k, places in chosen if places]
        if chosen:
            groups.append(_group(robots, spans, chosen))
    return tuple(groups)


def _group(
    robots: Robots,
    spans: tuple[tuple[int, int], ...],
    chosen: list[tuple[int, tuple[int, ...]]],
) -> Group:
    """Return the group of some robots, with their tasks of each level."""
    places, size = {}, 0
    for robot in robots:
        start, stop = spans[robot]
        places[robot] = slice(size, size + stop - start)
        size += stop - start
    joints = np.concatenate([np.arange(*spans[robot]) for robot in robots])
    columns: slice | Indices = joints
    if joints[-1] - joints[0] + 1 == joints.size:
        columns = slice(int(joints[0]), int(joints[-1]) + 1)
    ranks = tuple([k for k, _ in chosen])
    return Group(columns, size, places, ranks, tuple([tasks for _, tasks in chosen]))
