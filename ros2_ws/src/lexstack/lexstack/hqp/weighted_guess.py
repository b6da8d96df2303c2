"""A guess of what holds at the optimum: the hierarchy as one program with weights.

With weights that fall from level to level the optimum tends to the strict one, never reaches it,
and is badly conditioned on the way; but the bounds and rows that it touches are, nearly always,
those of the strict optimum. So its chi is thrown away and its active set tried.
"""

from __future__ import annotations

import numpy as np

from lexstack.hqp.hierarchy import Hierarchy
from lexstack.hqp.level_qp import LevelQp, level_qp
from lexstack.types import Vector

# Weights of squared residuals: from the highest level to the term ||chi|| below the lowest, and
# from each level to the next. Beside 1, a double does not hold much less.
_RANGE = 1e-12
_STEP = 1e-6


def weighted_qp(hierarchy: Hierarchy, lower: Vector, upper: Vector) -> LevelQp:
    """Return all levels as one program; its rows are the bounds, then the inequality rows."""
    levels = hierarchy.levels
    n = lower.size
    step = max(_STEP, _RANGE ** (1.0 / max(len(levels), 1))) ** 0.5
    scale = np.empty(hierarchy.lower.size)
    weight = 1.0
    for level in levels:
        scale[level.rows] = weight / level.norm
        weight *= step
    rows = hierarchy.matrix * scale[:, None]
    ends = hierarchy.lower * scale, hierarchy.upper * scale
    hard = np.eye(n), lower, upper
    return level_qp(rows, hierarchy.equal, ends, hard, norm=1.0, proximal=_RANGE, simple=n)
