"""The bridge: the gap to the source, latched at the trigger, fades out while A stays optimal.

At the trigger t0, with chi_cmd the last command and chi_S the source's optimum:

    delta = chi_cmd(t0-) - chi_S(t0)           epsilon = J chi_cmd(t0-) - b_1(t0)

and then, within A's own bounds,

    1) min || J chi - (b_1 + (1 - alpha) epsilon) ||
    2) min || chi - (chi_S + (1 - alpha) delta) ||

At alpha = 0 the command goes on as it was, at alpha = 1 it is the source's; in between it is the
optimum of one strict problem, which needs neither the old stack nor a third solve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack_core.linear import LinearTask, Vector


@dataclass(frozen=True, slots=True)
class Bridge:
    """What was latched at the trigger.

    Attributes:
        delta: chi_cmd - chi_S, shape (n,), m/s and rad/s.
        epsilon: per task of level 1 the residual of chi_cmd, or None where level 1 goes on as it
            was: then its optimum is not touched, and strictness holds through the transition.
    """

    delta: Vector
    epsilon: tuple[Vector, ...] | None


def latch(
    command: Vector, source: Vector, level: tuple[LinearTask, ...], level_goes_on: bool
) -> Bridge:
    """Return the bridge from ``command`` to ``source``, both shape (n,).

    Args:
        command: chi_cmd(t0-), the last command.
        source: chi_S(t0), the source's optimum for this tick.
        level: level 1 of the new stack at this tick.
        level_goes_on: whether level 1 and its references are those that A followed until now.
    """
    epsilon = None if level_goes_on else tuple(task.residual(command) for task in level)
    return Bridge(command - source, epsilon)


def bridged(
    bridge: Bridge, level: tuple[LinearTask, ...], source: Vector, alpha: float
) -> tuple[tuple[LinearTask, ...], ...]:
    """Return the two levels that A solves at this tick, given alpha in [0, 1]."""
    rest = 1.0 - alpha
    first = level
    if bridge.epsilon is not None:
        first = tuple(
            LinearTask(task.name, task.matrix, task.lower + rest * gap, task.upper + rest * gap)
            for task, gap in zip(level, bridge.epsilon, strict=True)
        )
    return (first, (follow_chi(source + rest * bridge.delta),))


def follow_chi(target: Vector) -> LinearTask:
    """Return the task chi -> target, shape (n,), T(33)."""
    return LinearTask.equality("follow_chi", np.eye(target.size), target)


def follows_within(new: tuple[LinearTask, ...], old: tuple[LinearTask, ...], reach: Vector) -> bool:
    """Return whether a step of ``reach`` (n,) in chi makes up for what a level's targets moved.

    Args:
        new: the level now.
        old: the level as it was asked for before, at the same state: the same tasks.
        reach: how far each joint's velocity may change, m/s and rad/s.
    """
    matrix = np.vstack([task.matrix for task in new])
    moved = np.concatenate([a.lower - b.lower for a, b in zip(new, old, strict=True)])
    step = np.linalg.lstsq(matrix, np.nan_to_num(moved), rcond=None)[0]
    return bool((np.abs(step) <= reach).all())


def same_level(one: tuple[LinearTask, ...], other: tuple[LinearTask, ...]) -> bool:
    """Return whether two levels, made linear at the same state, ask for the same."""
    return len(one) == len(other) and all(
        a.name == b.name
        and np.array_equal(a.matrix, b.matrix)
        and np.array_equal(a.lower, b.lower)
        and np.array_equal(a.upper, b.upper)
        for a, b in zip(one, other, strict=True)
    )
