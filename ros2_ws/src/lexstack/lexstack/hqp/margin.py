"""How far rows may turn before a level could come near a singularity: a test of microseconds.

Singular values change no faster than the rows. Let G be the rows above a level at some state, g
their least singular value, A the level's rows, and s the least singular value of A in the null
space of G. At another state whose rows differ by d from these (Frobenius norm), a unit vector in
the null space has at most the length d / g in the old row space, so the singular value there is

    s' >= s sqrt(1 - (d/g)^2) - |A| d/g - d >= s - d (1 + (s + |A|) / g)

A ``Margin`` keeps the rows and singular values of a state that was looked at: as long as s' is
above ``SINGULAR``, or the error so small that none of ``lift`` is asked for, the levels are
regular. Whatever a margin does not cover is looked at by ``regular_levels``: margins change what
is worked out, and no result.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.compiled import kernel
from lexstack.hqp.bend import FIRM, Bend
from lexstack.hqp.groups import Group
from lexstack.hqp.lift import FARTHEST, SINGULAR, TOLD, GroupLevel
from lexstack.hqp.problem import HqpProblem
from lexstack.hqp.regular import MET, SURE
from lexstack.robots import Kinematics
from lexstack.types import Matrix

_FLOAT = np.dtype(np.float64)
_EVERY = 1_000_000  # columns
_ROUNDING = 1.0 + 1e-6
_WIDE = 1.5  # of what needs a row: it is worth while to know how the level above bends

Place = tuple[int, int]
"""A task of a problem: its level, and its place in it."""


@dataclass(frozen=True, slots=True)
class Seen:
    """A level as it was looked at.

    Attributes:
        tasks: of the level, each with 1 / K.
        least: its least singular value s, above ``TOLD``.
        slope: by which s falls with d, at most.
        enough: with a larger singular value it has no row; ``SINGULAR`` in its unit.
        scale: the largest root of a weight among its tasks.
        size: of a curved level below no other one |A|^2 + joints, in its unit; 0 for others, and
            where the rows do not show the whole Jacobian.
    """

    tasks: tuple[tuple[Place, float], ...]
    least: float
    slope: float
    enough: float
    scale: float
    size: float

    def small(self, least: float, moved: float) -> float:
        """Return the squared error up to which no row is added, see ``regular_levels``.

        Args:
            least: a lower bound of the singular values.
            moved: d.
        """
        size = MET
        if self.size:
            joined = math.sqrt(self.size) + moved
            largest = (self.enough / self.scale) ** 2 / _ROUNDING
            size = max(size, min(least * least / (joined * joined), largest / self.size))
        return (size * self.scale) ** 2


@dataclass(frozen=True, slots=True)
class Margin:
    """Of one group of robots.

    Attributes:
        group: the robots.
        rows: of all tasks, at the state that was looked at.
        levels: of the group, the highest first.
        bend: of two levels, what the first one bends in the null space of its rows; None: not
            known.
    """

    group: Group
    rows: tuple[tuple[Place, Matrix], ...]
    levels: tuple[Seen, ...]
    bend: Bend | None

    @classmethod
    def of(
        cls,
        group: Group,
        levels: Sequence[GroupLevel],
        problem: HqpProblem,
        kinematics: Kinematics,
    ) -> Margin | None:
        """Return it for levels that are regular at this state; None: nothing can be said.

        Args:
            group: whose tasks all have a curve.
            levels: of the group, the highest first.
            problem: that they are of.
            kinematics: of this tick.
        """
        free: Matrix = np.eye(group.size)
        above, firm, seen = np.empty((0, group.size)), math.inf, []
        for k, level in enumerate(levels):
            rows, most = level.matrix.shape[0], free.shape[1]
            if not most or (level.curved and rows > most) or firm <= FIRM:
                return None
            last, left = k + 1 == len(levels), level.matrix.dot(free) if k else level.matrix
            if last:
                values = np.linalg.svd(left, compute_uv=False)
            else:
                _, values, vt = np.linalg.svd(left)
            if not values[-1] > TOLD * level.scale:
                return None
            seen.append(_seen(_places(group, k), level, float(values[-1]), firm))
            if not last:
                free = free.dot(vt[min(rows, most) :].T)
                above = np.concatenate((above, level.matrix))
                firm = float((np.linalg.svd(above, compute_uv=False) if k else values)[-1])
        places = [place for k in range(len(levels)) for place in _places(group, k)]
        kept = tuple((place, problem.levels[place[0]][place[1]].matrix) for place in places)
        bend = None
        if len(levels) == 2 and seen[-1].least < _WIDE * seen[-1].enough:
            bend = Bend.of(levels, kinematics)
        return cls(group, kept, tuple(seen), bend)

    def covers(self, problem: HqpProblem) -> bool:
        """Return whether the levels are regular as far as the margin knows; never so for a NaN.

        ``problem`` is of the same tasks, and no joint of the group stands at a position limit.
        """
        levels, moved = problem.levels, self._moved(problem)
        for level in self.levels:
            least = level.least - moved * level.slope
            if least > level.enough:
                continue
            if not least > TOLD * level.scale * _ROUNDING:
                return False
            error = 0.0
            for (k, place), factor in level.tasks:
                asked = levels[k][place].correction
                error += float(asked.dot(asked)) * factor * factor
            if error <= level.small(least, moved):
                continue
            if self.bend is None or level is not self.levels[-1]:
                return False
            length = min(math.sqrt(error), FARTHEST * level.scale)
            squared = least * least
            need = self.bend.most(moved) * length * (1.0 - squared / level.enough**2)
            if not need <= SURE * squared:
                return False
        return True

    def _moved(self, problem: HqpProblem) -> float:
        """Return d, by how much the rows differ from those of the state that was looked at."""
        square, fast = 0.0, kernel("lexstack.hqp.kernel.margins")
        columns = self.group.columns
        start, stop = (columns.start, columns.stop) if isinstance(columns, slice) else (0, _EVERY)
        for (k, place), rows in self.rows:
            matrix = problem.levels[k][place].matrix
            if matrix is not rows:
                if fast is None or not matrix.dtype is rows.dtype is _FLOAT:
                    square += _squared(matrix - rows)
                else:
                    square += fast.squared_change(matrix, rows, start, stop)
        return math.sqrt(square)


def _squared(matrix: Matrix) -> float:
    """Return the squared Frobenius norm."""
    return float(np.vdot(matrix, matrix))


def _places(group: Group, k: int) -> list[Place]:
    """Return the tasks of a group's level."""
    return [(group.ranks[k], place) for place in group.tasks[k]]


def _seen(places: list[Place], level: GroupLevel, least: float, firm: float) -> Seen:
    """Return a level as it is looked at.

    Args:
        places: of its tasks.
        level: at this state.
        least: its least singular value s.
        firm: that of the rows above, g; infinite where there are none.
    """
    tasks = tuple(
        (place, 1.0 / task.curve.gain)
        for place, task in zip(places, level.tasks, strict=True)
        if task.curve is not None
    )
    size = 0.0
    if level.curved and not level.nested and not level.partial:
        joints = level.matrix.shape[1]
        size = (float(np.vdot(level.matrix, level.matrix)) + joints * level.scale**2) * _ROUNDING
    slope = 1.0
    if math.isfinite(firm):
        slope += (least + float(np.linalg.norm(level.matrix, 2))) / firm
    enough = SINGULAR * level.scale * _ROUNDING
    return Seen(tasks, least, slope, enough, level.scale, size)
