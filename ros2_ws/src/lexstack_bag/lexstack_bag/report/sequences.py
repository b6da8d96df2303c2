"""Figures and table of the sequences of tasks that the HTMPC executed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from lexstack.types import Matrix, Vector
from lexstack_bag.figures.figures import Metrics
from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.report.blocks import Path, Span, paths_from_above, series, timeline
from lexstack_bag.report.figure import Figure
from lexstack_bag.report.html import render
from lexstack_bag.report.tables import number, table
from lexstack_bag.report.traces import ROBOTS, SERIES
from lexstack_bag.run.run import ProgressStream, Run
from lexstack_bag.run.sequences import STEADY_WINDOW, SequenceMetrics, goals_in

_LEAST = 1e-3  # mm: a logarithm has no zero
_PLACES = 1e-3  # m, goals nearer to each other are one
_FINEST = 1e-9  # s


def figures(
    run: Run, time_series: TimeSeries, phases: Sequence[Phase], metrics: Metrics
) -> list[Figure]:
    """Return the figures of a run's sequences; none without sequences."""
    if not metrics.sequences:
        return []
    return [
        _tasks(metrics.sequences, time_series),
        _from_above(run, time_series, metrics.sequences),
        _errors(run, phases),
        _solve_times(run, phases),
    ]


def section(metrics: Metrics) -> Markup:
    """Return the table of sequences and the one of their tasks, as HTML; '' without sequences."""
    if not metrics.sequences:
        return Markup()
    ratio = metrics.st_over_ht
    return render(
        "sequences.html",
        ratio=f"{ratio:.2f}" if ratio else "",
        count=sum(len(one.tasks) for one in metrics.sequences),
        steady_window=f"{STEADY_WINDOW:g}",
        table=_sequences_table(metrics.sequences),
        tasks=_tasks_table(metrics.sequences),
    )


def _sequences_table(sequences: Sequence[SequenceMetrics]) -> Markup:
    """Return a row for every sequence."""
    head = ["robot", "architecture", "begun [s]", "tasks done", "completed in [s]", "plans [Hz]"]
    head += ["failed plans", "mean error of the levels [mm]"]
    rows = [
        [
            Markup("<b>{}</b>").format(one.robot),
            f"{one.architecture.upper()}-Arch",
            f"{one.begun_s:.2f}",
            f"{one.done} of {one.count}",
            "cancelled" if one.cancelled else _done(one.completion_s),
            number(one.plans_hz, 1),
            f"{one.failed_plans}",
            ", ".join(number(value, 1) for value in one.level_error_mm.values()),
        ]
        for one in sequences
    ]
    return table(head, rows, "sequences")


def _tasks_table(sequences: Sequence[SequenceMetrics]) -> Markup:
    """Return a row for every task."""
    head = ["sequence", "task", "moves", "first from [s]", "done at [s]", "took [s]"]
    head += ["error [mm]", "error [mrad]"]
    rows = [
        [
            one.title,
            task.name,
            task.moves,
            f"{task.first_s:.2f}",
            _done(task.done_s),
            number(None if task.done_s is None else task.done_s - task.first_s, 2),
            number(task.error_mm, 2),
            number(task.error_mrad, 2),
        ]
        for one in sequences
        for task in one.tasks
    ]
    return table(head, rows, "tasks")


def _done(seconds: float | None) -> str:
    """Return a time, or that the thing was not done."""
    return "not done" if seconds is None else f"{seconds:.2f}"


def _tasks(sequences: Sequence[SequenceMetrics], time_series: TimeSeries) -> Figure:
    """Return which task was the first one when."""
    spans = [
        Span(one.title, _kind(task.name), task.first_s, task.done_s or one.end_s)
        for one in sequences
        for task in one.tasks
    ]
    whole = float(time_series.time[0]), float(time_series.time[-1])
    return timeline(
        "tasks",
        "Tasks over time",
        "Which task was the first one that was not done. Rounds of one task have one colour.",
        spans,
        whole,
    )


def _from_above(run: Run, time_series: TimeSeries, sequences: Sequence[SequenceMetrics]) -> Figure:
    """Return the ways of bases and tools while sequences were under way, and their goals.

    Two architectures are laid over each other, from where each base began.
    """
    compared = len({one.architecture for one in sequences}) > 1
    paths = []
    for i, one in enumerate(sequences):
        inside = (time_series.time >= one.begun_s) & (time_series.time <= one.end_s)
        robot = run.robots.index(one.robot)
        color = SERIES[i % len(SERIES)] if compared else ROBOTS[robot % len(ROBOTS)]
        x0, y0 = _origin(run, one.robot) if compared else (0.0, 0.0)
        for what, places, dash in (
            ("base", time_series.base, "solid"),
            ("tool", time_series.ee, "dot"),
        ):
            x, y = places[inside, robot, 0] - x0, places[inside, robot, 1] - y0
            paths.append(Path(f"{one.title}: {what}", x, y, color, dash))
    where = "Both from where their bases began. " if compared else ""
    return paths_from_above(
        "sequence-paths",
        "The ways of the sequences, from above",
        f"{where}Solid: the bases; dotted: the tools; a dot: where they began. Symbols: the tasks' "
        "goals.",
        paths,
        _goals(run, relative=compared),
    )


def _goals(run: Run, *, relative: bool) -> dict[str, tuple[float, float]]:
    """Return where the tasks' goals are, by name [m]; those at one place once."""
    goals: dict[str, tuple[float, float]] = {}
    for name, plan_topics in run.plan_topics.items():
        x0, y0 = _origin(run, name) if relative else (0.0, 0.0)
        for task in goals_in(plan_topics).values():
            if task.kind in ("ee_orientation", "joint_positions"):
                continue  # they are nowhere
            x, y = task.points[-1][0] - x0, task.points[-1][1] - y0
            known = any(abs(x - a) + abs(y - b) < _PLACES for a, b in goals.values())
            whose = "" if len(run.plan_topics) == 1 or relative else f", {name}"
            if not known:
                goals.setdefault(_kind(task.name) + whose, (x, y))
    return goals


def _origin(run: Run, robot: str) -> tuple[float, float]:
    """Return where a robot's base began [m]."""
    x, y, _ = run.resolved.scenario.robots[robot].base
    return x, y


def _errors(run: Run, phases: Sequence[Phase]) -> Figure:
    """Return how far each level is from its reference, on logarithmic axes."""
    time, places = _times(run)
    rows = []
    for name, plan_topics in run.plan_topics.items():
        progress = plan_topics.progress
        errors = np.maximum(1e3 * np.asarray(progress.errors), _LEAST)
        goal = np.maximum(1e3 * progress.error, _LEAST)
        values = {
            f"{name}, level {k + 1}": _placed(column, places[name], len(time))
            for k, column in enumerate(errors.T)
        }
        values[f"{name}, goal of the first task"] = _placed(goal, places[name], len(time))
        rows.append((f"{name}: distance", "mm", values))
    return series(
        "level-errors",
        "Errors of the levels of the MPC",
        "Logarithmic. Of each level the distance from its reference at that time; and how far the "
        "first task's goal still is. Values below 1 µm are drawn at 1 µm.",
        time,
        rows,
        log=True,
        phases=phases,
    )


def _solve_times(run: Run, phases: Sequence[Phase]) -> Figure:
    """Return the solve time of every plan."""
    time, places = _times(run)
    values = {
        name: _placed(1e3 * plan_topics.progress.solve_time, places[name], len(time))
        for name, plan_topics in run.plan_topics.items()
    }
    period = 1e3 / run.resolved.scenario.htmpc.rate
    return series(
        "plan-times",
        "Solve times of the MPC",
        f"Wall time of every plan; one is due every {period:g} ms.",
        time,
        [("solve time", "ms", values)],
        phases=phases,
    )


def _times(run: Run) -> tuple[Vector, dict[str, Matrix]]:
    """Return the even times of plans [s], and where on them each robot's plans are."""
    streams: dict[str, ProgressStream] = {
        name: plan_topics.progress for name, plan_topics in run.plan_topics.items()
    }
    stamps = np.unique(np.concatenate([stream.stamp for stream in streams.values()]))
    steps = np.diff(stamps)
    period = run.resolved.scenario.htmpc.ticks(run.resolved.scenario.rate) * run.period
    step = min(float(steps[steps > _FINEST].min(initial=period)), period)
    count = round(float(stamps[-1] - stamps[0]) / step) + 1
    places = {
        name: np.round((stream.stamp - stamps[0]) / step).astype(np.int64)
        for name, stream in streams.items()
    }
    return stamps[0] + step * np.arange(count), places


def _placed(values: Vector, places: Matrix, count: int) -> Vector:
    """Return values at their places, shape (count,), nan where there are none."""
    found = np.full(count, np.nan)
    found[places] = values
    return found


def _kind(name: str) -> str:
    """Return a task's name without its round."""
    return name.partition("#")[0]
