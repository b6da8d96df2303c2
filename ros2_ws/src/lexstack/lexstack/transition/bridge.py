"""The bridge: the gap to the source, latched at the trigger, fades out; each tick is an optimum.

At the trigger t0, with chi_A what the command would be without it and chi_S the source's optimum:

    delta = chi_A(t0) - chi_S(t0)              epsilon = J chi_A(t0) - b_1(t0)

and then, within the bounds of the command,

    1) min || J chi - (b_1 + (1 - alpha) epsilon) ||
    2) min || chi - (chi_S + (1 - alpha) delta) ||

At alpha = 0 the command goes on as it was, at alpha = 1 it is the source's; in between it is the
optimum of one strict problem, which needs neither the old stack nor a third solve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.types import LinearTask, Vector


@dataclass(frozen=True, slots=True)
class Bridge:
    """What was latched at the trigger.

    Attributes:
        delta: chi_A - chi_S, shape (n,), m/s and rad/s.
        epsilon: per task of level 1 the residual of chi_A, zero for inequality rows; or None where
            level 1 goes on as it was: then its optimum is not changed, and strictness holds through
            the transition.
        motion: what the gap of this tick has besides (1 - alpha) delta, shape (n,), as of
            ``GapMotion.at``.
    """

    delta: Vector
    epsilon: tuple[Vector, ...] | None
    motion: Vector | None = None


def latch(
    command: Vector, source: Vector, level: tuple[LinearTask, ...], level_goes_on: bool
) -> Bridge:
    """Return the bridge from ``command`` to ``source``, both shape (n,).

    Args:
        command: chi_A(t0): without a blend the optimum of the old stack at this tick, in a blend
            the last command moved on as the blend would have moved it.
        source: chi_S(t0), the source's optimum for this tick.
        level: level 1 of the new stack at this tick.
        level_goes_on: whether level 1 and its references are those that were followed until now.
    """
    epsilon = None if level_goes_on else tuple(_gap(task, command) for task in level)
    return Bridge(command - source, epsilon)


def bridged(
    bridge: Bridge, level: tuple[LinearTask, ...], source: Vector, alpha: float
) -> tuple[tuple[LinearTask, ...], Vector]:
    """Return level 1 and the chi to follow below it, shape (n,), given alpha in [0, 1]."""
    rest = 1.0 - alpha
    first = level
    if bridge.epsilon is not None:
        pairs = zip(level, bridge.epsilon, strict=True)
        first = tuple([_moved_by(task, rest * gap) for task, gap in pairs])
    target = source + rest * bridge.delta
    if bridge.motion is not None:
        target += bridge.motion
    return first, target


def _moved_by(task: LinearTask, gap: Vector) -> LinearTask:
    """Return a task with its ends moved by ``gap``, shape (m,)."""
    lower = task.lower + gap
    upper = lower if task.upper is task.lower else task.upper + gap
    return LinearTask(task.name, task.matrix, lower, upper, task.curve, task.feed, task.frame)


def _gap(task: LinearTask, command: Vector) -> Vector:
    """Return what a task's equality rows lack at ``command``, shape (m,); zero for inequalities.

    Inequalities hold at once: a distance to an obstacle must be kept during a blend too, and the
    rows of such tasks may stand for something else from tick to tick.
    """
    return np.where(task.lower == task.upper, task.residual(command), 0.0)


def goes_on(new: tuple[LinearTask, ...], old: tuple[LinearTask, ...], reach: Vector) -> bool:
    """Return whether a level has the rows and targets of another one, at the same state.

    Targets that differ by less than the joints can follow in one tick need no bridge: a moving
    reference is no jump.

    Args:
        new: the level now.
        old: the level that was followed until now.
        reach: how far each joint's velocity may change in one tick, (n,), m/s and rad/s.
    """
    by_name = {task.name: task for task in old}
    if len(new) != len(old) or not all(task.name in by_name for task in new):
        return False
    same = tuple(by_name[task.name] for task in new)
    if not all(np.array_equal(a.matrix, b.matrix) for a, b in zip(new, same, strict=True)):
        return False
    return follows_within(new, same, reach)


def follows_within(new: tuple[LinearTask, ...], old: tuple[LinearTask, ...], reach: Vector) -> bool:
    """Return whether a step of ``reach`` (n,) in chi makes up for what a level's targets moved.

    Args:
        new: the level now.
        old: the level as it was asked for before, at the same state: the same tasks.
        reach: how far each joint's velocity may change, m/s and rad/s.
    """
    if not new:
        return True
    pairs = list(zip(new, old, strict=True))
    lower = np.concatenate([_moved(a.lower, b.lower) for a, b in pairs])
    upper = np.concatenate([_moved(a.upper, b.upper) for a, b in pairs])
    matrix = np.vstack([task.matrix for task in new])
    ends = [lower] if np.array_equal(lower, upper) else [lower, upper]
    return all(
        not moved.any()
        or bool((np.abs(np.linalg.lstsq(matrix, moved, rcond=None)[0]) <= reach).all())
        for moved in ends
    )


def _moved(one: Vector, other: Vector) -> Vector:
    """Return how far ends of intervals have moved, 0 where there is no end."""
    finite = np.isfinite(one) & np.isfinite(other)
    return np.where(finite, one, 0.0) - np.where(finite, other, 0.0)
