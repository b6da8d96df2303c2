"""An independent oracle for level 1: how much a command gives away of what the box allows."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from lexstack.limits import Bounds
from lexstack.types import LinearTask, Vector

_SMALL = 1e-9  # m/s and rad/s: a residual below it needs no oracle, its excess is no larger


def level_excess(level: tuple[LinearTask, ...], chi: Vector, bounds: Bounds) -> float:
    """Return the norm of a level's residual at chi minus the least within the box, m/s and rad/s.

    scipy's bounded-variable least squares shares no code with the solvers of the library.

    Args:
        level: equality tasks.
        chi: shape (n,), inside ``bounds``.
        bounds: the box in which chi was chosen; its lower ends at most its upper ends.
    """
    matrix = np.vstack([task.matrix for task in level])
    target = np.concatenate([task.lower for task in level])
    residual = float(np.linalg.norm(matrix @ chi - target))
    if residual <= _SMALL:
        return residual
    return residual - _least(matrix, target, bounds)


def _least(matrix: np.ndarray, target: Vector, bounds: Bounds) -> float:
    """Return the least norm of matrix x - target within the bounds."""
    lower, upper = bounds.lower, bounds.upper
    fixed = upper - lower < 1e-12
    free = np.flatnonzero(~fixed)
    rest = target - matrix[:, fixed] @ lower[fixed]
    if not free.size:
        return float(np.linalg.norm(rest))
    norms = []
    # At ties BVLS may divide by zero; another order of the variables breaks them.
    for order in (free, free[::-1]):
        with np.errstate(divide="ignore", invalid="ignore"):
            found = lsq_linear(
                matrix[:, order],
                rest,
                (lower[order], upper[order]),
                method="bvls",
                tol=1e-14,
                max_iter=1000,
            )
        x = np.clip(np.nan_to_num(found.x), lower[order], upper[order])
        norms.append(float(np.linalg.norm(matrix[:, order] @ x - rest)))
        if found.status > 0:
            break
    return min(norms)
