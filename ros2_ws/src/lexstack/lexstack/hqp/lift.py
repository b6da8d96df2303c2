"""Rows that let a level near a singularity come to rest: Newton's method where Gauss-Newton fails.

Along a direction d with the singular value s of the level's rows the true second derivative is
s^2 + d^T B d. Out of reach s goes to 0 while B stays positive: Gauss-Newton then wants velocities
without limit, and whatever bounds them makes it swing. In the free directions Z of the level,

    J Z = U S V^T        d_i = Z v_i        e: the error, scaled to the length of b / K
    need_i = max(0, d_i^T B(e) d_i) max(0, 1 - s_i^2 / SINGULAR^2)
    a_i    = clip((1 - s_i^2 / need_i - LATE) / (1 - LATE), 0, 1)
    e'     = e - U (1 - a) U^T e                   the part that nothing can reduce
    W L W^T = S_k B(e') S_k on Z                   S_k = 1; of linear tasks a_i on d_i, 1 elsewhere
    R1 = sqrt(L) W^T Z^T                           of the eigenvalues above a part of |e|
    R2_i = sqrt(max(0, need_i - s_i^2 - |R1 d_i|^2)) d_i^T

and a level of linear tasks becomes [J; R1; R2] chi -> [b; 0; 0]. Of curved tasks the error is
saturated without its lost part, K (sat(e - e') + e'), and ``valley`` has the targets. R2 makes the
step along a lost direction Newton's, R1 keeps the levels below off the directions that cost it at
second order.

The B of a level is that of its Lagrangian: what the levels above bend counts too, by their
multipliers lambda = (G G^T + reg I)^-1 G J^T e, with G the rows above, those that were added to
them (which do not bend), and the joints that stand at their position limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from lexstack.hqp.curvature import add_curvature
from lexstack.hqp.group_level import GroupLevel
from lexstack.hqp.hierarchy import Mask
from lexstack.hqp.rank_revealing_qr import factorise
from lexstack.hqp.scipy_parts import lapack
from lexstack.hqp.valley import Model, logarithm, singular, symmetric
from lexstack.robots import Kinematics
from lexstack.types import Matrix, Vector

__all__ = ["FARTHEST", "SINGULAR", "TOLD", "Above", "GroupLevel", "lift", "pressed"]

TOLD = 0.02  # the least singular value below which a level is told of, damped or not
SINGULAR = 0.15  # m or 1: with a larger singular value a level is as strict as ever
_LATE = 0.8  # of the lift, before a direction counts as lost: rows block what is below them
_WEAK = 5e-6  # m, times |e|: only what truly does not bend is left to the levels below
_RANK = 1e-8  # of a level's norm, as in the solver
_REGULAR = 1e-6  # added to G G^T; rows have norms of about 1
_FELT = 1e-6  # m, times |e|: a joint that a level presses less is not pressed by it
FARTHEST = 0.3  # m or rad: tasks that are linear in the joints do not saturate their errors


@dataclass(slots=True)
class Above:
    """What the levels above leave, and what of them bends.

    Attributes:
        free: Z, orthonormal, shape (r, free directions).
        rows: all rows of the levels above, those that were added too, and of the held joints.
        levels: the levels with curved tasks, and where their rows begin among ``rows``.
    """

    free: Matrix
    rows: list[Matrix] = field(default_factory=list)
    levels: list[tuple[int, GroupLevel]] = field(default_factory=list)

    @classmethod
    def of_held(cls, held: Mask) -> Above:
        """Return it above the first level, with some joints held; a mask of shape (r,)."""
        unit = np.eye(held.size)
        return cls(unit[:, ~held], [unit[held]])

    def take(self, level: GroupLevel) -> None:
        """Take a level up to which nothing was added."""
        reduced = level.matrix.dot(self.free)
        norm = float(np.linalg.norm(level.matrix))
        null = factorise(reduced, _RANK * (norm or 1.0)).null
        self.add(level, np.empty((0, len(self.free))), null)

    def add(self, level: GroupLevel, lifts: Matrix, null: Matrix) -> None:
        """Take a level up, with the rows that were added to it and the freedom that it leaves."""
        if level.curved:
            self.levels.append((sum(len(rows) for rows in self.rows), level))
        self.rows += [level.matrix, lifts]
        self.free = self.free.dot(null)


@dataclass(slots=True)
class Bending:
    """B of one level at one state, given those above it."""

    level: GroupLevel
    above: Above
    kinematics: Kinematics
    places: dict[int, slice]

    def at(self, error: Vector) -> Matrix:
        """Return B(e), symmetric, in the free directions of the level."""
        size = len(self.above.free)
        total = np.zeros((size, size))
        if self.level.curved:
            self._add(total, self.level, error)
        if self.above.levels:
            multipliers = _multipliers(self.above.rows, error.dot(self.level.matrix))
            for start, level in self.above.levels:
                # L = |e|^2 / 2 + lambda . x: what is above counts with the other sign than e.
                self._add(total, level, -multipliers[start : start + len(level.matrix)])
        free = self.above.free
        result: Matrix = free.T.dot(total).dot(free)
        return result

    def _add(self, total: Matrix, level: GroupLevel, weights: Vector) -> None:
        """Add what a level bends, with the weights of its rows, shape (m,)."""
        for task, start in zip(level.tasks, level.starts, strict=True):
            mine = weights[start : start + task.lower.size]
            add_curvature(total, task, mine, self.kinematics, self.places)


def pressed(levels: list[GroupLevel], sides: Vector) -> Mask:
    """Return which of the joints at a position limit are pressed against it, shape (r,).

    By the highest level that feels it, as at the optimum of the hierarchy: this depends on the
    state alone, and not on what a solution with or without added rows made of it.

    Args:
        levels: the highest first.
        sides: +1 or -1 where a joint stands at its upper or lower limit, shape (r,).
    """
    held: Mask = np.zeros(sides.size, dtype=np.bool_)
    unknown = sides != 0.0
    rows: list[Matrix] = []
    for level in levels:
        if not unknown.any():
            break
        # At rest ½ |e|^2 is least, whatever the task shortens: the signs are those of e itself.
        error = level.unsaturated() if level.curved else level.error
        gradient = error.dot(level.matrix)
        if rows:
            gradient = gradient - _multipliers(rows, gradient).dot(np.concatenate(rows))
        size = float(np.linalg.norm(error))
        felt = unknown & (np.abs(gradient) > _FELT * level.scale * size)
        held |= felt & (gradient * sides > 0.0)
        unknown &= ~felt
        rows.append(level.matrix)
    return held


def _multipliers(rows: list[Matrix], gradient: Vector) -> Vector:
    """Return lambda of rows that a level must not touch, given its J^T e, shape (r,)."""
    matrix = np.concatenate(rows)
    gram = matrix.dot(matrix.T)
    gram.reshape(-1)[:: len(gram) + 1] += _REGULAR
    _, found, failed = lapack.dposv(gram, matrix.dot(gradient))
    if failed:
        raise np.linalg.LinAlgError("the multipliers of the levels above are not to be had")
    result: Vector = found
    return result


def lift(
    level: GroupLevel, above: Above, kinematics: Kinematics, places: dict[int, slice]
) -> tuple[Matrix, Vector, Vector, float]:
    """Return the rows to add to a level, what to add to its error, their targets, and sigma.

    The targets are over the gain; sigma is the least singular value. No row is added where the
    level is regular. ``above`` takes the level up.

    Raises:
        numpy.linalg.LinAlgError: a factorisation failed, as it does for numbers that are none.
    """
    reduced = level.matrix.dot(above.free)
    u, values, vt = singular(reduced)
    size = len(values)
    if size < len(level.matrix) and level.curved:
        least = 0.0  # fewer freedoms than rows: some direction of the task is lost
    else:
        least = float(values[-1]) if size else SINGULAR
    rank = int(np.count_nonzero(values > _RANK * max(level.scale, values.max(initial=0.0))))
    null, more = vt[rank:].T, np.zeros_like(level.error)
    rows, target = np.empty((0, reduced.shape[1])), np.zeros(0)
    size_of_error = float(np.linalg.norm(level.error))
    if least < SINGULAR * level.scale and size_of_error > 0.0 and reduced.shape[1]:
        bending = Bending(level, above, kinematics, places)
        raw = level.unsaturated() if level.curved else level.error
        longest = size_of_error if level.curved else min(size_of_error, FARTHEST * level.scale)
        size_of_raw = float(np.linalg.norm(raw))
        rows, lost, bent = _rows(raw * (longest / size_of_raw), (u, values, vt), bending)
        if len(rows):
            model = Model.of(reduced, rows, longest)
            rows, null, target = model.rows, model.null, np.zeros(len(model.rows))
            if level.curved:
                shrink = longest / size_of_raw
                true = reduced.T.dot(reduced) + bent / shrink + logarithm(level, raw, reduced)
                asked, step = _asked(level, (raw, lost.dot(raw)), shrink, (reduced, model, true))
                own = u[:, :size]  # the more of a direction is lost, the more of Newton's step
                step *= float((own * lost.dot(own)).sum(axis=0).max(initial=0.0))
                more = asked + reduced.dot(step) - level.error
                target = rows.dot(step)
    added: Matrix = rows.dot(above.free.T)
    above.add(level, added, null)
    return added, more, target, least / level.scale


def _asked(
    level: GroupLevel,
    error: tuple[Vector, Vector],
    shrink: float,
    curvature: tuple[Matrix, Model, Matrix],
) -> tuple[Vector, Vector]:
    """Return what a damped level asks to remove, shape (m,), and what to add to its step.

    Args:
        level: of curved tasks.
        error: not saturated, and the part of it that is lost, shape (m,) each.
        shrink: by how much the lost part is scaled down.
        curvature: J, the model, and the true second derivative, in the free directions.
    """
    raw, lost = error
    reduced, model, true = curvature
    kept = level.saturated(raw - lost)
    asked = kept + shrink * lost
    gradients = asked.dot(reduced), (kept + lost).dot(reduced)
    return asked, model.step(true, gradients, math.sqrt(float(raw.dot(raw))))


def _rows(
    error: Vector, factors: tuple[Matrix, Vector, Matrix], bending: Bending
) -> tuple[Matrix, Matrix, Matrix]:
    """Return R1 and R2 in the free directions, the lost part of errors, shape (m, m), and B(e)."""
    u, values, vt = factors
    size = len(values)
    squares, singular = values * values, SINGULAR * bending.level.scale
    directions = vt[:size]
    bent = bending.at(error)
    need = (directions.dot(bent) * directions).sum(axis=1)
    if bending.level.curved:
        # What the level asks for now may be at rest where the error as it is would not.
        asked = bending.at(bending.level.error)
        need = np.maximum(need, (directions.dot(asked) * directions).sum(axis=1))
    need = np.maximum(need, 0.0) * np.maximum(1.0 - squares / singular**2, 0.0)
    lifted = need > squares
    if not lifted.any() and (size == len(u) or not bending.level.curved):
        return np.empty((0, len(vt))), np.zeros((0, 0)), bent
    lost = np.zeros(size)
    lost[lifted] = 1.0 - squares[lifted] / need[lifted]
    lost = np.minimum(np.maximum((lost - _LATE) / (1.0 - _LATE), 0.0), 1.0)
    own = u[:, :size]
    beyond = error - own.dot((1.0 - lost) * own.T.dot(error))
    kept = (own * (1.0 - lost)).dot(own.T)
    shape = bending.at(beyond)
    if not bending.level.curved:
        along = np.ones(len(vt))
        along[:size] = lost
        selected = (vt.T * along).dot(vt)
        shape = selected.dot(shape).dot(selected)
    eigenvalues, vectors = symmetric(shape)
    strong = eigenvalues > _WEAK * bending.level.scale * float(np.linalg.norm(error))
    first = (np.sqrt(eigenvalues[strong]) * vectors[:, strong]).T
    rest = need - squares - np.square(first.dot(directions.T)).sum(axis=0)
    left = lifted & (rest > 0.0)
    second = np.sqrt(rest[left])[:, None] * directions[left]
    return np.concatenate((first, second)), np.eye(len(u)) - kept, bent
