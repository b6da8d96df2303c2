"""When a phase has settled: the time after which every error stays near its steady state."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack.tasks import PostureParameters, posture_target
from lexstack.types import Vector
from lexstack_bag.figures.phases import BASE_TASKS, EE_TASKS, POSTURE_TASKS, Phase, tasks_of
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.run.run import Run
from lexstack_config.reader import build

# An error has settled once it stays below its steady state plus this.
SETTLED_BAND = 1.0  # mm for end effectors and bases, mrad for postures


def settled_after(
    run: Run,
    team: Team,
    time_series: TimeSeries,
    phase: Phase,
    ticks: NDArray[np.bool_],
    steady: NDArray[np.bool_],
    *,
    others: Iterable[Vector] = (),
) -> float | None:
    """Return the time from a phase's start until all its errors have settled [s], by the stamps.

    The errors are those of the stack's tasks: end-effector and base positions [mm], the distance
    of the arm from its posture, as a norm over its joints [mrad], and those of others.

    Args:
        run: the run.
        team: its robots.
        time_series: its time series.
        phase: the phase.
        ticks: which ticks are in the phase, shape (T,).
        steady: which of them make the steady state, shape (T,).
        others: errors of its other tasks, shape (T,) each [mm, mrad].

    Returns:
        None if an error never settles, or the stack has no such task.
    """
    times = []
    for errors in (*_errors(run, team, time_series, phase.stack), *others):
        inside = errors[ticks]
        if not inside.size or not steady.any():
            return None
        outside = np.flatnonzero(~(inside <= np.mean(errors[steady]) + SETTLED_BAND))
        first = int(outside[-1]) + 1 if outside.size else 0
        if first == inside.size:
            return None
        times.append(float(time_series.time[ticks][first]) - phase.start)
    return round(max(0.0, *times), 9) if times else None


def _errors(run: Run, team: Team, time_series: TimeSeries, stack: str) -> Iterator[Vector]:
    """Yield the errors of a stack's tasks at every tick, shape (T,) each."""
    for name in tasks_of(run, stack, EE_TASKS):
        yield time_series.ee_error[:, run.robots.index(name)]
    for name in tasks_of(run, stack, BASE_TASKS):
        yield time_series.base_error[:, run.robots.index(name)]
    yield from posture_errors(run, team, stack).values()


def posture_errors(run: Run, team: Team, stack: str) -> dict[str, Vector]:
    """Return the distance of each arm from the posture that a stack asks for, shape (T,) [mrad].

    It is the norm over the joints; a prismatic joint counts with its millimetres. A robot without
    such a task is left out.
    """
    found = {}
    for name, task in tasks_of(run, stack, POSTURE_TASKS).items():
        robot = team.index(name)
        where = f"stack {stack}: posture"
        parameters = build(PostureParameters, task.parameters, where)
        target = posture_target(team.robots[robot], parameters, where)
        arm = run.plant.q[:, team.q_slices[robot]][:, team.robots[robot].arm_q]
        found[name] = 1e3 * np.linalg.norm(arm - target, axis=1)
    return found
