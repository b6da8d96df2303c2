"""Continuous activation of tasks, after Kim et al. 2019."""

from __future__ import annotations

from lexstack_core.hqp import HqpProblem
from lexstack_core.linear import LinearTask, Vector
from lexstack_core.transition.bridge import Bridge
from lexstack_core.transition.methods.view import Levels, View


def activation(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return both stacks, level by level, the old fading out and the new fading in.

    A task that is partly active asks for h b + (1 - h) A chi*, with h its activation and chi* the
    optimum of the levels above: at h = 0 it asks for what they give anyway. One further problem
    is solved for each level that comes or goes.
    """
    levels: Levels = ()
    for new, old in _pairs(view.new(), view.old()):
        level = tuple(task for task in new if task.name in {other.name for other in old})
        coming = tuple(task for task in new if task not in level)
        going = tuple(task for task in old if task.name not in {other.name for other in new})
        if coming or going:
            above = view.solve(HqpProblem(levels, view.bounds))
            level += tuple(_partly(task, alpha, above) for task in coming)
            level += tuple(_partly(task, 1.0 - alpha, above) for task in going if alpha < 1.0)
        levels = (*levels, level) if level else levels
    return HqpProblem(levels, view.bounds)


def _pairs(new: Levels, old: Levels) -> list[tuple[tuple[LinearTask, ...], ...]]:
    """Return the two stacks' levels of equal rank; the shorter stack ends with empty ones."""
    depth = max(len(new), len(old))
    return [(new[k] if k < len(new) else (), old[k] if k < len(old) else ()) for k in range(depth)]


def _partly(task: LinearTask, active: float, chi: Vector) -> LinearTask:
    """Return a task with its activation in [0, 1], given the optimum of the levels above."""
    value = (1.0 - active) * (task.matrix @ chi)
    return LinearTask(
        task.name, task.matrix, active * task.lower + value, active * task.upper + value
    )
