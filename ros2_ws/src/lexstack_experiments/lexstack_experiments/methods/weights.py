"""Weights: both stacks in one, the old one's rows fading out and the new one's fading in."""

from __future__ import annotations

import numpy as np

from lexstack.hqp import HqpProblem
from lexstack.transition import Bridge, Levels, View
from lexstack.types import LinearTask


def weights(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return the levels of equal rank merged, weighted alpha (new) and 1 - alpha (old).

    In between, tasks of both stacks share a level: the priorities are soft.
    """
    new, old = view.new(), view.old()
    levels: Levels = tuple(
        _weighted(new[k : k + 1], alpha, "to ") + _weighted(old[k : k + 1], 1.0 - alpha, "from ")
        for k in range(max(len(new), len(old)))
    )
    return HqpProblem(tuple(level for level in levels if level), view.context.bounds)


def _weighted(levels: Levels, weight: float, prefix: str) -> tuple[LinearTask, ...]:
    """Return the tasks of one level (or none) with their squared residuals weighted."""
    if weight <= 0.0:
        return ()
    scale = float(np.sqrt(weight))
    return tuple(
        LinearTask(prefix + task.name, scale * task.matrix, scale * task.lower, scale * task.upper)
        for level in levels
        for task in level
    )
