"""Which joints a problem couples, and into which independent subproblems it can be divided.

Two joints are coupled if one task, of any level, has coefficients for both; a task whose matrix is
a multiple of the unit matrix couples none. Clusters are the joints that are coupled directly or
through others. With chi_c the joints of cluster c, every level is a sum over clusters,

    ||A chi - b||^2 = sum_c ||A_c chi_c - b_c||^2    (and likewise with intervals),

and the bounds are joint by joint: the lexicographic optimum of the whole is that of each cluster.
So clusters are solved separately, and the cost grows with the number of robots and not with its
cube. Small clusters are put together into subproblems of some size, because a solve of 20 joints
costs hardly more than one of 10.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lexstack.compiled import kernel
from lexstack.hqp.hierarchy import Indices, unit_scale
from lexstack.hqp.problem import HqpProblem
from lexstack.types import LinearTask, Matrix

Place = slice | Indices
"""Rows or columns: a slice where they stand side by side."""

Footprint = tuple[int, bytes]
"""Of a task: its number of rows; the mask of the columns that it has coefficients for."""

_FLOAT = np.dtype(np.float64)
_REMEMBERED = 1000  # matrices
_UNIT = b""  # the mask of a task whose rows are those of the unit matrix, in this order


@dataclass(frozen=True, slots=True)
class Share:
    """The rows of one task that belong to a subproblem.

    Attributes:
        task: its place among all tasks of all levels.
        rows: of the task; None for all.
    """

    task: int
    rows: Place | None


@dataclass(frozen=True, slots=True)
class Subproblem:
    """Some clusters of a problem, to be solved together.

    Attributes:
        columns: its joints.
        levels: the rows that each level has on them.
        rows: their places among all rows of the problem, in the order of ``levels``.
        last: the last of these places, -1 where there are none.
    """

    columns: Place
    levels: tuple[tuple[Share, ...], ...]
    rows: Indices
    last: int


class Structure:
    """Divides problems into subproblems; knows the footprints of matrices that cannot change."""

    def __init__(self, size: int) -> None:
        """Make subproblems of whole clusters, together at most ``size`` joints if they can."""
        self._size = size
        # With the matrix, so that no other one gets its id.
        self._known: dict[int, tuple[Matrix, Footprint]] = {}

    def subproblems_of(self, problem: HqpProblem) -> tuple[Subproblem, ...]:
        """Return the subproblems of a problem.

        Only zeros that are zeros count: a subproblem has all rows of its joints, exactly.
        """
        n = problem.bounds.lower.size
        prints = tuple(
            [tuple([self._footprint(task.matrix) for task in level]) for level in problem.levels]
        )
        return _subproblems(n, prints, self._size)

    def _footprint(self, matrix: Matrix) -> Footprint:
        """Return the footprint of a matrix."""
        known = self._known.get(id(matrix))
        if known is not None:
            return known[1]
        found = footprint(matrix)
        # Remembered only if nobody can write to it: neither through this array nor through one that
        # it is a view of. The table is emptied when it is full; that costs time and nothing else.
        if matrix.base is None and not matrix.flags.writeable:
            if len(self._known) >= _REMEMBERED:
                self._known.clear()
            self._known[id(matrix)] = matrix, found
        return found


def footprint(matrix: Matrix) -> Footprint:
    """Return what the subproblems of a problem depend on: the rows and the columns of a task."""
    rows, columns = matrix.shape
    # Row i of a multiple of the unit matrix has joint i alone: each subproblem takes its own rows
    # of it.
    if rows == columns and unit_scale(matrix):
        return rows, _UNIT
    # Exact zeros alone: to drop a coefficient because it is small would change the optimum.
    fast = kernel("lexstack.hqp.kernel.margins")
    if fast is None or matrix.dtype is not _FLOAT or not matrix.flags.c_contiguous:
        return rows, matrix.any(axis=0).tobytes()
    moved = np.empty(columns, dtype=np.bool_)
    fast.columns_of(matrix, moved)
    return rows, moved.tobytes()


def share(task: LinearTask, rows: Place | None, columns: Place) -> LinearTask:
    """Return the rows of a task that belong to a subproblem, on its joints."""
    if rows is None:
        matrix = task.matrix[:, columns]
        return LinearTask(task.name, matrix, task.lower, task.upper)
    lower = task.lower[rows]
    upper = lower if task.upper is task.lower else task.upper[rows]
    both = isinstance(rows, slice) and isinstance(columns, slice)
    matrix = task.matrix[rows, columns] if both else task.matrix[rows][:, columns]
    return LinearTask(task.name, matrix, lower, upper)


@lru_cache(maxsize=64)
def _subproblems(
    n: int, prints: tuple[tuple[Footprint, ...], ...], size: int
) -> tuple[Subproblem, ...]:
    """Return the subproblems of a problem with these footprints.

    Cached by the footprints: as long as the tasks and their zeros stay, so do the subproblems.
    """
    masks = [_columns(mask, n) for level in prints for _, mask in level]
    groups = _packed(_clusters(n, [columns for columns in masks if columns is not None]), size)
    owner = np.empty(n, dtype=np.intp)
    for number, group in enumerate(groups):
        owner[group] = number
    levels: list[list[list[Share]]] = [[[] for _ in prints] for _ in groups]
    places: list[list[Indices]] = [[] for _ in groups]
    # ``task`` counts the tasks and ``start`` the rows of all levels, in the order of the problem.
    task, start = 0, 0
    for k, level in enumerate(prints):
        for rows, _ in level:
            columns = masks[task]
            if columns is None:
                for number, group in enumerate(groups):
                    levels[number][k].append(Share(task, _place(group)))
                    places[number].append(start + group)
            else:
                # All columns of a task are in one cluster, so the first one names the subproblem. A
                # task without columns asks nothing of any joint; the first subproblem takes its
                # rows.
                number = int(owner[columns[0]]) if columns.size else 0
                levels[number][k].append(Share(task, None))
                places[number].append(start + np.arange(rows))
            task, start = task + 1, start + rows
    found = []
    for number, group in enumerate(groups):
        own = np.concatenate([np.empty(0, dtype=np.intp), *places[number]])
        shares = tuple(tuple(level) for level in levels[number])
        found.append(Subproblem(_place(group), shares, own, int(own.max(initial=-1))))
    return tuple(found)


def _columns(mask: bytes, n: int) -> Indices | None:
    """Return the columns of a mask, None for the unit matrix."""
    return None if mask == _UNIT and n else np.flatnonzero(np.frombuffer(mask, dtype=np.bool_))


def _clusters(n: int, coupled: list[Indices]) -> list[Indices]:
    """Return the joints of each cluster, in the order of their first joints."""
    # Connected components by their smallest joint. Invariant: label[j] is a joint of the cluster of
    # j, and at most j. Each task gives all its joints the smallest of their labels. Labels only
    # fall, so this ends; then all joints of a task have one label, hence all of a cluster.
    label = np.arange(n)
    changed = True
    while changed:
        before = label.copy()
        for columns in coupled:
            if columns.size:
                # A label that falls here may differ from those of tasks that were passed already:
                # hence the outer loop, until a pass changes nothing.
                label[columns] = label[columns].min()
        changed = bool((label != before).any())
    return [np.flatnonzero(label == first) for first in np.unique(label)]


def _packed(clusters: list[Indices], size: int) -> list[Indices]:
    """Return neighbouring clusters together as long as they have at most ``size`` joints.

    A cluster is never divided: one that is larger makes a subproblem of its own. The joints of a
    subproblem are sorted, because the clusters in it may interleave.
    """
    groups: list[list[Indices]] = [[]]
    for cluster in clusters:
        if groups[-1] and sum(other.size for other in groups[-1]) + cluster.size > size:
            groups.append([])
        groups[-1].append(cluster)
    return [np.sort(np.concatenate([np.empty(0, dtype=np.intp), *group])) for group in groups]


def _place(indices: NDArray[np.intp]) -> Place:
    """Return a slice where the indices are consecutive: it selects a view, and copies nothing."""
    if all(b == a + 1 for a, b in pairwise(indices.tolist())):
        first = int(indices[0]) if indices.size else 0
        return slice(first, first + indices.size)
    return indices
