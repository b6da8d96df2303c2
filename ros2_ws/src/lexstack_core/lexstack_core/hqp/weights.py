"""A guess of what holds at the optimum: the hierarchy as one program with weights.

With weights that fall from level to level the optimum tends to the strict one, never reaches it,
and is badly conditioned on the way; but which bounds and rows it touches are, nearly always, those
of the strict optimum. So its chi is thrown away and its active set tried.
"""

from __future__ import annotations

import numpy as np

from lexstack_core.hqp.qp import LevelQp
from lexstack_core.hqp.rows import LevelRows
from lexstack_core.linear import Vector

# From the highest level to the term ||chi|| below the lowest, in the square of the residual, and
# at most so much from level to level. More than that a double cannot hold beside 1.
_RANGE = 1e-12
_STEP = 1e-6


def weighted_qp(levels: list[LevelRows], lower: Vector, upper: Vector) -> LevelQp:
    """Return the hierarchy as one program in chi, shape (n,), and one slack per inequality row.

    Its first n rows are the bounds, the others the inequality rows of all levels in order.
    """
    n = lower.size
    step = max(_STEP, _RANGE ** (1.0 / max(len(levels), 1))) ** 0.5
    s = sum(int(np.count_nonzero(~level.equal)) for level in levels)
    objective, target = [], []
    rows, lows, highs = [np.eye(n, n + s)], [lower], [upper]
    weight, column = 1.0, n
    for level in levels:
        scale = weight / level.norm
        wide = np.zeros((level.lower.size, n + s))
        wide[:, :n] = level.matrix
        if not level.exact:
            free = np.flatnonzero(~level.equal)
            slack = column + np.arange(free.size)
            wide[free, slack] = -level.norm
            rows.append(wide[free])
            lows.append(level.lower[free])
            highs.append(level.upper[free])
            wide[free] = 0.0
            wide[free, slack] = level.norm
            column += free.size
        objective.append(scale * wide)
        target.append(scale * np.where(level.equal, level.lower, 0.0))
        weight *= step
    ...
