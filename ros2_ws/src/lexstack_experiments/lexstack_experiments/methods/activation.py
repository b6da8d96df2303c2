"""Continuous activation of tasks, after Kim et al. 2019."""

from __future__ import annotations

from lexstack.hqp import HqpProblem
from lexstack.transition import Bridge, Levels, View
from lexstack.types import LinearTask, Vector


def activation(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return both stacks, level by level, the old fading out and the new fading in.

    A task that is partly active asks for h b + (1 - h) A chi, with h its activation and chi the
    optimum of the hierarchy without it: at h = 0 it asks for what is there anyway. Without what
    comes that hierarchy is the old stack, without what goes the new one; both are solved beside,
    without acceleration limits, T(35).
    """
    new, old, free = view.new(), view.old(), view.context.free_bounds()
    without_coming = view.context.solve(HqpProblem(old, free))
    without_going = view.context.solve(HqpProblem(new, free))
    levels: Levels = ()
    for arriving, leaving in _pairs(new, old):
        kept = {task.name for task in arriving} & {task.name for task in leaving}
        level = tuple(task for task in arriving if task.name in kept)
        level += tuple(
            _partly(task, alpha, without_coming) for task in arriving if task.name not in kept
        )
        if alpha < 1.0:
            level += tuple(
                _partly(task, 1.0 - alpha, without_going)
                for task in leaving
                if task.name not in kept
            )
        levels = (*levels, level) if level else levels
    return HqpProblem(levels, view.context.bounds)


def _pairs(new: Levels, old: Levels) -> list[tuple[tuple[LinearTask, ...], ...]]:
    """Return the two stacks' levels of equal rank; the shorter stack ends with empty ones."""
    depth = max(len(new), len(old))
    return [(new[k] if k < len(new) else (), old[k] if k < len(old) else ()) for k in range(depth)]


def _partly(task: LinearTask, active: float, chi: Vector) -> LinearTask:
    """Return a task with its activation in [0, 1], given what the others give, chi."""
    value = (1.0 - active) * (task.matrix @ chi)
    return LinearTask(
        task.name, task.matrix, active * task.lower + value, active * task.upper + value
    )
