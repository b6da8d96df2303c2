"""Two runs on one page: their figures side by side, their traces over each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from lexstack.types import Vector
from lexstack_bag.figures.compare import MESSAGES, TROUBLE, Comparison, Difference, paired
from lexstack_bag.figures.figures import Analysis
from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import COMMANDER
from lexstack_bag.report import control, tables
from lexstack_bag.report.bands import with_bands
from lexstack_bag.report.figure import Figure
from lexstack_bag.report.html import render
from lexstack_bag.report.layout import level, stacked
from lexstack_bag.report.page import document, figure_html
from lexstack_bag.report.traces import ROBOTS, SERIES, VERMILLION, Plain, drawn, line, typed
from lexstack_bag.run.run import Names
from lexstack_bag.run.wholeness import Band, bands_of

_BEFORE = 0.5  # s, shown before a switch
_MOST_SAMPLES = 2500  # of one trace
_MOST_SWITCHES = 12
_DASHES = ("solid", "dash")  # of the first run and of the second
_SINCE, _SINCE_FIRST = "time since the switch [s]", "time since the first switch [s]"
_ORDINALS = ("First", "Second")
_LEAST = 1e-3  # mm: a logarithm has no zero


Sides = tuple[Analysis, Analysis]
"""The two runs."""


def write_comparison(path: Path, sides: Sides, comparison: Comparison) -> None:
    """Write the page of two runs to one HTML file."""
    pairs = list(_pairs(*(side.phases for side in sides)))
    figures = [
        _switch(sides, pair, number) for number, pair in enumerate(pairs[:_MOST_SWITCHES], start=1)
    ]
    if sides[0].run.plant.q.shape[1] == sides[1].run.plant.q.shape[1]:
        figures.append(_commands(sides))
    path.write_text(document("Two lexstack runs", _body(comparison, figures)), encoding="utf-8")


def _body(comparison: Comparison, figures: Sequence[Figure]) -> Markup:
    """Return the page's content: figures that differ, then folded up those that do not."""
    shown = [entry for entry in comparison.differences if entry.group != MESSAGES]
    same = [entry for entry in shown if entry.first == entry.second]
    other = [entry for entry in shown if entry.first != entry.second]
    messages = [entry for entry in comparison.differences if entry.group == MESSAGES]
    setup = [(key, *both) for key, both in comparison.setup.items() if key != TROUBLE]
    trouble = comparison.setup.get(TROUBLE, ())
    return render(
        "comparison.html",
        names=comparison.names,
        setup=setup,
        notes=[f"{which} run: {text}." for which, text in zip(_ORDINALS, trouble, strict=False)],
        differing=_table(other),
        count_same=len(same),
        same=_table(same),
        changed=sum(entry.first != entry.second for entry in messages),
        count_messages=len(messages),
        messages=_table(messages),
        figures=figures,
        figure_html=figure_html,
    )


def _table(entries: Sequence[Difference]) -> Markup:
    """Return a table of figures; empty without any."""
    rows = [
        [
            entry.group,
            entry.figure,
            entry.unit,
            _number(entry.first),
            _number(entry.second),
            _number(entry.change, ""),
            "" if entry.relative is None else f"{100 * entry.relative:+.1f} %",
            "" if entry.better in (None, "same") else f"the {entry.better}",
        ]
        for entry in entries
    ]
    head = ["of", "figure", "unit", "first", "second", "change", "relative", "better"]
    return tables.table(head, rows, "differences") if rows else Markup()


def _number(value: float | None, otherwise: str = "none") -> str:
    """Return a number, or a word where a run has no such figure."""
    return otherwise if value is None else f"{value:.5g}"


def _pairs(
    first: Sequence[Phase], second: Sequence[Phase]
) -> Iterator[tuple[Phase | None, Phase | None]]:
    """Yield the phases after the first switch: of both runs where their stacks follow alike."""
    # The first phase of a run begins with no switch.
    pairs = paired(first, second)
    yield from (p for p in pairs if p[0] is not first[0] and p[1] is not second[0])


def _switch(sides: Sides, pair: tuple[Phase | None, Phase | None], number: int) -> Figure:
    """Return errors, alpha and accelerations of both runs after one switch, from its trigger on."""
    phase = pair[0] or pair[1]
    assert phase is not None
    ends = [one.end - one.start for one in pair if one is not None]
    span = (-_BEFORE, max(ends))
    traces: list[Plain] = []
    for which, (side, one) in enumerate(zip(sides, pair, strict=True)):
        if one is not None:
            traces += _after(side, one, which)
    titles = ["EE error [mm]", "base error [mm]", "α [-]", "acceleration / limit [-]"]
    layout = stacked(titles, 190, (), span)
    for key in ("yaxis", "yaxis2"):
        layout[key] |= {"type": "log", "dtick": 1, "exponentformat": "power"}
    layout["xaxis4"]["title"]["text"] = _SINCE
    layout["shapes"].append(level(1.0, 4, VERMILLION))
    alone = "" if None not in pair else " Only one of the runs has this switch."
    figure = Figure(
        f"switch-{number}",
        f"Switch {number}: to {phase.title}",
        "Both runs from the trigger on; the dashed line at 1 is the acceleration limit." + alone,
        traces,
        layout,
        linked=False,
    )
    zeros = [None if one is None else one.start for one in pair]
    return _with_bands(figure, sides, zeros, _SINCE, span)


def _with_bands(
    figure: Figure,
    sides: Sides,
    zeros: Sequence[float | None],
    title: str,
    span: tuple[float, float],
) -> Figure:
    """Return a figure with the bands of both runs, from their zeros of time on."""
    for side, zero, ordinal in zip(sides, zeros, _ORDINALS, strict=True):
        if zero is None:
            continue
        moved = (Band(b.kind, b.start - zero, b.end - zero) for b in bands_of(side.run))
        bands = [
            Band(b.kind, max(b.start, span[0]), min(b.end, span[1]))
            for b in moved
            if b.start < span[1] and b.end > span[0]
        ]
        figure = with_bands(figure, bands, title, f", {ordinal.lower()}")
    return figure


def _after(side: Analysis, phase: Phase, which: int) -> list[Plain]:
    """Return the traces of one run around one switch."""
    run, time_series, status = side.run, side.time_series, side.run.transition
    begin, end = phase.start - _BEFORE, phase.end
    dash, ordinal = _DASHES[which], ("first", "second")[which]
    traces = []
    for row, errors in enumerate((time_series.ee_error, time_series.base_error), start=1):
        for i, robot in enumerate(run.robots):
            series = _cut(
                time_series.time, np.maximum(errors[:, i], _LEAST), begin, end, phase.start
            )
            name = f"{robot}, {ordinal}"
            style: dict[str, Any] = {"row": row, "dash": dash, "unit": "mm", "legend": row == 1}
            traces.append(line(series, name, ROBOTS[i % len(ROBOTS)], **style))
    mine = _rows(status.robots, (phase.robots or run.robots)[0], len(status.tick))
    series = _cut(status.stamp[mine], status.alpha[mine], begin, end, phase.start)
    traces.append(line(series, f"α, {ordinal}", "#000000", row=3, dash=dash))
    ratios = time_series.acceleration_ratio
    worst = np.max(np.where(np.isnan(ratios), 0.0, ratios), axis=1, initial=0.0)
    series = _cut(time_series.command_time, worst, begin, end, phase.start)
    traces.append(line(series, f"acceleration, {ordinal}", SERIES[3], row=4, dash=dash))
    return traces


def _rows(names: Names, robot: str, count: int) -> NDArray[np.bool_]:
    """Return which of ``count`` messages are about a robot: one per tick."""
    if not len(names):
        return np.ones(count, dtype=np.bool_)
    about = {text: not text or robot in text.split() for text in set(names.tolist())}
    return np.array([about[text] for text in names.tolist()], dtype=np.bool_)


def _commands(sides: Sides) -> Figure:
    """Return the command of any one joint in both runs, from their first switches on."""
    choices = control.joints(sides[0].run)
    zeros = [
        side.phases[1].start if len(side.phases) > 1 else side.phases[0].start for side in sides
    ]
    traces: list[Plain] = []
    for joint, label in enumerate(choices):
        unit = label.partition("[")[2].rstrip("]")
        for which, (side, zero) in enumerate(zip(sides, zeros, strict=True)):
            command = side.run.chi[COMMANDER]
            series = _cut(command.stamp, command.chi[:, joint], -np.inf, np.inf, zero)
            name = ("first", "second")[which]
            style: dict[str, Any] = {"dash": _DASHES[which], "unit": unit, "visible": joint == 0}
            traces.append(line(series, name, SERIES[which], **style))
    begins = [
        float(side.time_series.time[0]) - zero for side, zero in zip(sides, zeros, strict=True)
    ]
    ends = [
        float(side.time_series.time[-1]) - zero for side, zero in zip(sides, zeros, strict=True)
    ]
    layout = stacked(["command χ [m/s, rad/s]"], 320, (), (min(begins), max(ends)))
    layout["xaxis"]["title"]["text"] = _SINCE_FIRST
    figure = Figure(
        "commands",
        "Command of one joint",
        "Both commands, aligned at the first switch.",
        traces,
        layout,
        linked=False,
        choices=choices,
    )
    return _with_bands(figure, sides, zeros, _SINCE_FIRST, (min(begins), max(ends)))


def _cut(time: Vector, values: Any, begin: float, end: float, zero: float) -> Plain:
    """Return ``x0``, ``dx``, ``y`` of what lies between two times [s], counted from ``zero``."""
    inside = np.flatnonzero((time >= begin - 1e-9) & (time <= end + 1e-9))
    if not len(inside):
        return {"x0": 0.0, "dx": 1.0, "y": typed(np.empty(0))}
    times = time[inside]
    step = float(np.median(np.diff(times))) if len(times) > 1 else 1.0
    places = np.round((times - times[0]) / step).astype(int)
    dense = np.full(int(places[-1]) + 1, np.nan)
    dense[places] = np.asarray(values, dtype=np.float64)[inside]
    dense[np.isinf(dense)] = np.nan
    stride = max(1, -(-len(dense) // _MOST_SAMPLES))
    return drawn(dense, float(times[0]) - zero, step, stride)
