"""Errors of all tasks that have no columns of their own: of frames, axes, masses, couplings.

A task whose rows come with a ``Curve`` asks for K e; e is what is reported, before the task
shortened it. Where the gain differs from row to row it is K e over the largest gain. Tools, bases,
postures, and objects that two tools hold have figures of their own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack.types import Curve, LinearTask, Vector
from lexstack_bag.figures.levels import linear_levels, stack_of
from lexstack_bag.figures.phases import (
    BASE_TASKS,
    EE_TASKS,
    POSTURE_TASKS,
    RELATIVE_TASKS,
    Phase,
    held_objects,
    tasks_of,
)
from lexstack_bag.figures.series import TimeSeries, finite
from lexstack_bag.run.run import Run

_OWN = EE_TASKS | BASE_TASKS | POSTURE_TASKS
_FULL = 1e-6  # squared, of a shortened error that is no longer told from the limit
_LINEAR = 3  # rows of a tool's Jacobian, before the angular ones

Ticks = NDArray[np.bool_]
Errors = dict[str, tuple[Vector | None, Vector | None]]
"""By task: the norms of its linear [mm] and of its other rows [mrad], shape (T,); nan elsewhere."""


@dataclass(frozen=True, slots=True)
class TaskErrors:
    """The errors of one task in a phase; None where it has no such rows.

    A joint that slides counts among angles with its millimetres, as in postures.
    """

    task: str
    error_mm: float | None  # steady state
    error_mrad: float | None
    peak_error_mm: float | None
    peak_error_mrad: float | None


def errors_of(run: Run, team: Team, time_series: TimeSeries, phase: Phase, ticks: Ticks) -> Errors:
    """Return the errors of a phase's tasks at its ticks.

    Args:
        run: the run.
        team: its robots.
        time_series: its time series.
        phase: the phase.
        ticks: which are in the phase, shape (T,).
    """
    config, stack = run.resolved.stacks.get(phase.stack), stack_of(run, team, phase)
    if config is None or stack is None or not ticks.any():
        return {}
    objects = held_objects(run, phase.stack)
    own = {f"{name}/{kind}" for name in tasks_of(run, phase.stack, _OWN) for kind in _OWN}
    own |= {f"{name}/{kind}" for name in objects for kind in RELATIVE_TASKS}
    names = {task.name for level in stack.levels for task in level.tasks} - own
    if not names:
        return {}
    found: dict[str, tuple[Vector, Vector]] = {}
    there: dict[str, list[bool]] = {}
    for row in np.flatnonzero(ticks).tolist():
        for level in linear_levels(run, team, time_series, stack, row):
            for task in level:
                if task.name not in names or task.curve is None:
                    continue
                error, linear = _error(task, task.curve), _linear_rows(task)
                there[task.name] = [bool(linear.any()), not linear.all()]
                empty = np.full(len(ticks), np.nan), np.full(len(ticks), np.nan)
                both = found.setdefault(task.name, empty)
                for one, rows in zip(both, (linear, ~linear), strict=True):
                    one[row] = 1e3 * float(np.linalg.norm(error[rows]))
    return {
        name: (both[0] if there[name][0] else None, both[1] if there[name][1] else None)
        for name, both in found.items()
    }


def summed_up(errors: Errors, ticks: Ticks, steady: Ticks) -> tuple[TaskErrors, ...]:
    """Return the figures of a phase."""
    return tuple(
        TaskErrors(
            name,
            *(_value(np.mean, one, steady) for one in both),
            *(_value(np.max, one, ticks) for one in both),
        )
        for name, both in errors.items()
    )


def _value(take: object, errors: Vector | None, ticks: Ticks) -> float | None:
    """Return the mean or the largest error of some ticks; None of none."""
    if errors is None or not ticks.any() or not callable(take):
        return None
    return finite(take(errors[ticks]))


def _error(task: LinearTask, curve: Curve) -> Vector:
    """Return e of a task's rows, without weight and saturation, shape (m,)."""
    error = task.correction / (curve.gain * curve.scale)
    first = 0
    for size, limit in zip(curve.sizes or (3,) * len(curve.limits), curve.limits, strict=True):
        here = slice(first, first + size)
        part = error[here] * (curve.gain / limit)
        error[here] /= math.sqrt(max(_FULL, 1.0 - float(part @ part)))
        first += size
    return error


def _linear_rows(task: LinearTask) -> Ticks:
    """Return which rows are of positions, shape (m,)."""
    if task.frame is not None:
        return ~task.frame.axes[:, _LINEAR:].any(axis=1)
    place = np.arange(task.lower.size)
    return place < (_LINEAR if task.curve is not None and task.curve.signs else 0)
