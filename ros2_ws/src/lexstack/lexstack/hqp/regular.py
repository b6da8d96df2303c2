"""Whether levels are regular: a test that costs microseconds and needs no singular values.

Level k is regular where its rows, in the null space of the levels above, have no singular value
below a threshold. With the rows M of all levels so far, that is so exactly where M M^T with the
squared threshold taken off the diagonal of level k is positive definite (by Schur's complement),
and that is what a Cholesky factorisation finds out. Of levels with more rows than joints

    J^T J + mu A^T A - threshold^2 I          A: the rows above

is tested: where that is positive definite for some mu, it is so in the null space of A.

A level of linear tasks that fails this test may still get no row, as it needs one only where the
levels above bend more along one of its directions than it sees of that direction:

    d_i^T B d_i (1 - s_i^2 / SINGULAR^2) > s_i^2

``_bends_little`` looks at that, by the Gram matrix that is there already (see ``lift``).
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.hqp.curvature import add_curvature
from lexstack.hqp.lift import FARTHEST, SINGULAR, TOLD, GroupLevel
from lexstack.hqp.scipy_parts import lapack
from lexstack.robots import Kinematics
from lexstack.types import Matrix, Vector

dpotrf, dpotrs, dsyev = lapack.dpotrf, lapack.dpotrs, lapack.dsyev

MET = 1e-8  # m or rad: a smaller error asks for nothing that could get out of hand
_STIFF = 1e4  # mu
SURE = 0.9  # of what would need a row: nearer to it ``lift`` decides


def regular_levels(
    levels: list[GroupLevel],
    sides: Vector | None,
    kinematics: Kinematics,
    places: dict[int, slice],
) -> int:
    """Return to how many levels, from the first on, ``lift`` adds no row; or fewer than that.

    Args:
        levels: of one group, the highest first.
        sides: not zero where a joint stands at a position limit: it may not be able to move; None:
            no joint does.
        kinematics: of this tick.
        places: of each robot's joints among those of the levels.
    """
    matrices = [level.matrix for level in levels]
    rows = matrices[0] if len(matrices) == 1 else np.concatenate(matrices)
    stands = sides is not None and bool(np.count_nonzero(sides))
    if stands:
        rows = rows[:, sides == 0.0]
    gram: Matrix = rows.dot(rows.T)
    end = 0
    for place, level in enumerate(levels):
        start, end = end, end + len(level.matrix)
        threshold = _threshold(level, gram[start:end, start:end], rows.shape[1])
        if threshold == 0.0 or start == end:
            continue
        if end <= rows.shape[1]:
            tested = gram[:end, :end].copy()  # the one after it needs the diagonal as it was
            tested.reshape(-1)[start * (end + 1) :: end + 1] -= threshold
        elif level.curved:
            return place
        else:
            own, above = rows[start:end], rows[:start]
            tested = own.T.dot(own)
            tested += _STIFF * above.T.dot(above)
            tested.reshape(-1)[:: len(tested) + 1] -= threshold
        factor, failed = dpotrf(tested, 1, 0, 1)
        if failed or not factor[-1, -1] > 0.0:  # of numbers that are none it says nothing
            if stands or level.curved or not level.nested or end > rows.shape[1]:
                return place
            if not _bends_little(levels[: place + 1], gram[:end, :end], kinematics, places):
                return place
    return len(levels)


def _bends_little(
    levels: list[GroupLevel], gram: Matrix, kinematics: Kinematics, places: dict[int, slice]
) -> bool:
    """Return whether the last level, of linear tasks, needs no row for what is above it.

    With G the rows above and A those of the level, X = (G G^T)^-1 G A^T gives the multipliers of
    the levels above, X e, and A seen in their null space, A - X^T G; its singular values are the
    roots of the eigenvalues of A A^T - A G^T X.

    Args:
        levels: down to the one that is looked at; no row was added above it.
        gram: of all their rows.
        kinematics: of this tick.
        places: of each robot's joints.
    """
    level, above = levels[-1], levels[:-1]
    start = len(gram) - len(level.matrix)
    factor, failed = dpotrf(gram[:start, :start], 1, 0, 1)
    if failed or not factor[-1, -1] > 0.0:
        return False
    pulled, failed = dpotrs(factor, gram[:start, start:], 1)
    squares, vectors, failed = dsyev(gram[start:, start:] - gram[start:, :start].dot(pulled))
    singular = (SINGULAR * level.scale) ** 2
    if failed or not squares[0] > (TOLD * level.scale) ** 2:
        return False
    rows = np.concatenate([one.matrix for one in above])
    directions = (level.matrix - pulled.T.dot(rows)).T.dot(vectors)
    directions /= np.sqrt(squares)
    error = level.error
    size = math.sqrt(float(error.dot(error)))
    error = error * min(1.0, FARTHEST * level.scale / size)
    weights = pulled.dot(error)
    bending, first = np.zeros((rows.shape[1], rows.shape[1])), 0
    for one in above:
        last = first + len(one.matrix)
        if one.curved:
            for task, begin in zip(one.tasks, one.starts, strict=True):
                mine = weights[first + begin : first + begin + task.lower.size]
                add_curvature(bending, task, -mine, kinematics, places)
        first = last
    need = (bending.dot(directions) * directions).sum(axis=0)
    need *= np.maximum(1.0 - squares / singular, 0.0)
    return bool((need <= SURE * squares).all())


def _threshold(level: GroupLevel, gram: Matrix, joints: int) -> float:
    """Return the square of the singular value above which nothing is added to a level.

    A level of curved tasks alone has |B(e)| <= 2 |e| |J_v| |J_w| <= |e| (|J|^2 + joints), and gets
    no row where its smallest squared singular value is above that; not so where the rows are a part
    of the Jacobians alone.
    """
    size = math.sqrt(float(level.error.dot(level.error))) / level.scale
    if size <= MET:
        return 0.0
    squared = (SINGULAR * level.scale) ** 2
    if not level.curved or level.nested or level.partial or size * joints >= SINGULAR * SINGULAR:
        return squared
    most = size * (float(gram.trace()) + joints * level.scale**2)
    return min(squared, most)
