"""Whether levels are regular: a test that costs microseconds and needs no singular values.

Level k is regular where its rows, in the null space of the levels above, have no singular value
below a threshold. With the rows M of all levels so far, that is so exactly where M M^T with the
squared threshold taken off the diagonal of level k is positive definite (by Schur's complement),
and that is what a Cholesky factorisation finds out. Of levels with more rows than joints

    J^T J + mu A^T A - threshold^2 I          A: the rows above

is tested: where that is positive definite for some mu, it is so in the null space of A.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg.lapack import dpotrf

from lexstack_core.hqp.lift import SINGULAR, GroupLevel
from lexstack_core.linear import Matrix, Vector

_MET = 1e-8  # m or rad: a smaller error asks for nothing that could get out of hand
_STIFF = 1e4  # mu


def regular_levels(levels: list[GroupLevel], sides: Vector | None) -> int:
    """Return to how many levels, from the first on, ``lift`` adds no row; or fewer than that.

    Args:
        levels: of one group, the highest first.
        sides: not zero where a joint stands at a position limit: it may not be able to move; None:
            no joint does.
    """
    matrices = [level.matrix for level in levels]
    rows = matrices[0] if len(matrices) == 1 else np.concatenate(matrices)
    if sides is not None and np.count_nonzero(sides):
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
            return place
    return len(levels)


def _threshold(level: GroupLevel, gram: Matrix, joints: int) -> float:
    """Return the square of the singular value above which nothing is added to a level.

    A level of curved tasks alone has |B(e)| <= 2 |e| |J_v| |J_w| <= |e| (|J|^2 + joints), and gets
    no row where its smallest squared singular value is above that.
    """
    size = math.sqrt(float(level.error.dot(level.error))) / level.scale
    if size <= _MET:
        return 0.0
    squared = (SINGULAR * level.scale) ** 2
    if not level.curved or level.nested or size * joints >= SINGULAR * SINGULAR:
        return squared
    most = size * (float(gram.trace()) + joints * level.scale**2)
    return min(squared, most)
