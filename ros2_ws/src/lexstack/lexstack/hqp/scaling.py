"""Rows of any size, brought to norms of about 1 by powers of two, which round nothing.

What counts as zero in a pivot, a multiplier or a distance is judged on rows of about this size. A
level whose rows differ much is divided into bands of rows of about one size, the largest first: a
small row beside large ones would be lost in their rounding, in the rank as in the multipliers.
Bands are solved like levels. But they are not levels: a level minimises the squared distances of
all its rows as given, so a band gives way to those below it by the square of the ratio of their
sizes (`bands.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lexstack.hqp.hierarchy import Hierarchy, Indices, Signs
from lexstack.types import LinearTask, Vector

Levels = tuple[tuple[LinearTask, ...], ...]

# Norms of rows that are taken as they are: those of nearly all robots. Squared.
_SMALL, _LARGE = 2.0**-8, 2.0**8
# Exponents of two. Rows whose norms lie closer than the gap share a band, up to the spread.
_GAP = 7
_SPREAD = 16
# A row this much smaller than the largest one of its task is rounding, as in the Jacobian of a
# singular arm, and asks for nothing; and so is one that is nearly too small for a double.
_NOTHING = 2.0**-44
_LEAST = 2.0**-300


@dataclass(frozen=True, slots=True)
class Bands:
    """How the levels of a problem became those of a scaled hierarchy.

    Attributes:
        order: row i of the scaled hierarchy is row order[i] of the problem, shape (M,).
        owner: the level of the problem that each band belongs to.
        weight: the factor, a power of two, by which each band was divided.
        several: whether a level has more than one band.
    """

    order: Indices
    owner: tuple[int, ...]
    weight: tuple[float, ...]
    several: bool

    def rows_of(self, sides: Signs) -> Signs:
        """Return what is said of the problem's rows, said of the scaled ones."""
        return sides[self.order]

    def restored(self, sides: Signs) -> Signs:
        """Return what is said of the scaled rows, said of the problem's."""
        own = np.empty_like(sides)
        own[self.order] = sides
        return own

    def gap(self) -> float:
        """Return the least ratio of the sizes of two neighbouring bands of one level."""
        pairs = [
            self.weight[k] / self.weight[k + 1]
            for k in range(len(self.owner) - 1)
            if self.owner[k] == self.owner[k + 1]
        ]
        return min(pairs, default=np.inf)


def scaled(hierarchy: Hierarchy, levels: Levels) -> tuple[Hierarchy, Bands | None]:
    """Return a hierarchy whose rows all have norms of about 1, and how it came about.

    Args:
        hierarchy: of the levels; returned as it is, with None, where no row needs it.
        levels: of the problem.
    """
    squares = np.vecdot(hierarchy.matrix, hierarchy.matrix)
    if _moderate(squares):
        return hierarchy, None
    _take_jacobians_whole(squares, levels)
    if _moderate(squares) or _moderate(squares[squares > 0.0]):
        return hierarchy, None
    norms = np.sqrt(squares)
    exponents = np.frexp(np.where(_asks(norms, levels), norms, 0.0))[1]
    exponents[~_asks(norms, levels)] = np.iinfo(exponents.dtype).min
    order: list[Indices] = []
    owner: list[int] = []
    shift: list[int] = []
    for k, level in enumerate(hierarchy.levels):
        for rows, exponent in _bands(exponents[level.rows]):
            order.append(rows + level.rows.start)
            owner.append(k)
            shift.append(exponent)
    return _rebuilt(hierarchy, order, owner, shift)


def _take_jacobians_whole(squares: Vector, levels: Levels) -> None:
    """Give all rows of a level's Jacobians the squared norm of the largest one, in place, (M,).

    A short row of a Jacobian is a direction that the robot is losing, not another unit: next to a
    singularity it is rounding, and taken by itself it would ask for any velocity.
    """
    start = 0
    for level in levels:
        rows = []
        for task in level:
            end = start + task.lower.size
            if task.curve is not None:
                rows.append(slice(start, end))
            start = end
        largest = max([float(squares[part].max(initial=0.0)) for part in rows], default=0.0)
        for part in rows:
            squares[part] = largest


def _moderate(squares: Vector) -> bool:
    """Return whether all squared norms are in the range that needs no scaling."""
    if not squares.size:
        return True
    # Three times as fast as min() and max().
    least: float = squares.item(squares.argmin())
    return least >= _SMALL and squares.item(squares.argmax()) <= _LARGE


def _asks(norms: Vector, levels: Levels) -> np.ndarray:
    """Return which rows are more than rounding, from the norms of all rows, shape (M,)."""
    start, parts = 0, []
    for task in (task for level in levels for task in level):
        own = norms[start : start + task.lower.size]
        parts.append(own > max(_NOTHING * float(own.max(initial=0.0)), _LEAST))
        start += task.lower.size
    return np.concatenate(parts) if parts else np.zeros(0, dtype=np.bool_)


def _bands(exponents: np.ndarray) -> list[tuple[Indices, int]]:
    """Return the rows of each band of a level in their order, with the exponent of the largest.

    Rows that ask for nothing, whose exponent is the least integer, go with the first band.
    """
    nothing = np.iinfo(exponents.dtype).min
    values = np.unique(exponents[exponents != nothing])[::-1].tolist()
    if not values:
        return [(np.arange(exponents.size), 0)]
    bands = []
    for k, group in enumerate(_groups(values)):
        chosen = (exponents <= group[0]) & (exponents >= group[-1])
        if k == 0:
            chosen |= exponents == nothing
        bands.append((np.flatnonzero(chosen), int(group[0])))
    return bands


def _groups(values: list[int]) -> list[list[int]]:
    """Cut falling exponents at every wide gap, and at the widest one where a group is too long."""
    if len(values) == 1:
        return [values]
    gaps = [above - below for above, below in pairwise(values)]
    widest = max(gaps)
    if widest < _GAP and values[0] - values[-1] <= _SPREAD:
        return [values]
    cut = gaps.index(widest) + 1
    return [*_groups(values[:cut]), *_groups(values[cut:])]


def _rebuilt(
    hierarchy: Hierarchy, order: list[Indices], owner: list[int], shift: list[int]
) -> tuple[Hierarchy, Bands]:
    """Return the hierarchy of the bands, each divided by two to the power of its shift."""
    sizes = [rows.size for rows in order]
    place = np.concatenate([np.empty(0, dtype=np.intp), *order])
    powers = -np.repeat(np.array(shift, dtype=np.intp), sizes)
    lower = np.ldexp(hierarchy.lower[place], powers)
    upper = np.ldexp(hierarchy.upper[place], powers)
    rows = np.ldexp(hierarchy.matrix[place], powers[:, None]), lower, upper, hierarchy.equal[place]
    parted = frozenset(k for k, level in enumerate(owner) if owner.count(level) > 1)
    weight = tuple(float(np.ldexp(1.0, exponent)) for exponent in shift)
    return Hierarchy.of_rows(rows, sizes, parted), Bands(place, tuple(owner), weight, bool(parted))
