"""Figures of the motion: poses against their references, and the errors between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.report.blocks import Path, Span, paths_from_above, timeline
from lexstack_bag.report.figure import Figure
from lexstack_bag.report.layout import level, stacked
from lexstack_bag.report.traces import BLUE, DASHES, GREEN, ROBOTS, VERMILLION, Grid, line
from lexstack_bag.run.run import Run

_AXES = (("x", BLUE), ("y", VERMILLION))


def poses(run: Run, time_series: TimeSeries, phases: Sequence[Phase], grid: Grid) -> Figure:
    """Return the paper's Fig. 5: end effectors and bases, measured and desired."""
    rows = [
        (f"{name} EE [m]", time_series.ee[:, i], time_series.ee_target[:, i], "z")
        for i, name in enumerate(run.robots)
    ]
    rows += [
        (f"{name} base [m, rad]", time_series.base[:, i], time_series.base_target[:, i], "yaw")
        for i, name in enumerate(run.robots)
    ]
    traces = []
    for row, (_, actual, desired, third) in enumerate(rows, start=1):
        axes = (*_AXES, (third, GREEN))
        for k, (axis, color) in enumerate(axes):
            new = row == 1 or (k == 2 and row == len(run.robots) + 1)
            unit = "rad" if axis == "yaw" else "m"
            ticks = run.plant.tick
            traces += [
                line(
                    grid.series(ticks, desired[:, k]),
                    f"{axis} desired",
                    color,
                    row=row,
                    dash=DASHES[1 + k],
                    unit=unit,
                    legend=new,
                ),
                line(grid.series(ticks, actual[:, k]), axis, color, row=row, unit=unit, legend=new),
            ]
    return Figure(
        "poses",
        "End effectors and bases, measured and desired",
        "Fig. 5 of the paper. Solid: measured pose; broken: the reference in effect. Base "
        "references hold at all times but bind only while the stack has a base task. Vertical "
        "lines mark the switches.",
        traces,
        stacked([row[0] for row in rows], 175, phases, grid.span),
    )


def errors(run: Run, time_series: TimeSeries, phases: Sequence[Phase], grid: Grid) -> Figure:
    """Return the distances to the references, on logarithmic axes."""
    traces = []
    for row, values in enumerate((time_series.ee_error, time_series.base_error), start=1):
        for i, name in enumerate(run.robots):
            shown = np.maximum(values[:, i], 1e-3)  # a logarithm has no zero
            series = grid.series(run.plant.tick, shown)
            color, dash = ROBOTS[i % len(ROBOTS)], DASHES[i % len(DASHES)]
            trace = line(series, name, color, row=row, dash=dash, unit="mm", legend=row == 1)
            traces.append(trace)
    layout = stacked(["EE error [mm]", "base error [mm]"], 200, phases, grid.span)
    for key in ("yaxis", "yaxis2"):
        layout[key] |= {"type": "log", "dtick": 1, "exponentformat": "power"}
    layout["shapes"] += [level(1.0, 1, GREEN), level(5.0, 2, GREEN)]
    return Figure(
        "errors",
        "Distance to the references",
        "Logarithmic. The dashed green lines are our goals: 1 mm for the end effectors at the "
        "end, 5 mm for the bases after (A). A base error outside a phase with a base task is no "
        "fault: nothing asks for it there. Where a reference moves, as a trajectory does, this is "
        "the error of tracking it. Values below 1 µm are drawn at 1 µm.",
        traces,
        layout,
    )


def from_above(run: Run, time_series: TimeSeries) -> Figure:
    """Return the ways of bases and end effectors over the floor."""
    paths = []
    for i, name in enumerate(run.robots):
        color = ROBOTS[i % len(ROBOTS)]
        base, tool = time_series.base[:, i], time_series.ee[:, i]
        paths.append(Path(f"{name} base", base[:, 0], base[:, 1], color, "solid"))
        paths.append(Path(f"{name} EE", tool[:, 0], tool[:, 1], color, "dot"))
    obstacles = run.team().obstacles
    begin = obstacles.at(float(time_series.time[0]))
    circles = [(c[0], c[1], r) for c, r in zip(begin.tolist(), obstacles.radii, strict=True)]
    targets = {
        f"last EE target, {name}": tuple(time_series.ee_target[-1, i, :2].tolist())
        for i, name in enumerate(run.robots)
    }
    return paths_from_above(
        "from-above",
        "The ways of bases and end effectors, from above",
        "Solid: the bases; dotted: the end effectors; a dot: where they began. Circles: obstacles "
        "at the beginning.",
        paths,
        targets,
        circles,
    )


def stacks(phases: Sequence[Phase], grid: Grid) -> Figure:
    """Return which stack was in effect when, and what was blended."""

    def lane(what: str, phase: Phase) -> str:
        return ", ".join([what, *phase.robots])

    spans = [Span(lane("stack", p), p.stack, p.start, p.end) for p in phases]
    spans += [
        Span(lane("transition", p), f"to {p.stack}", p.start, p.adopted or p.end)
        for p in phases[1:]
    ]
    return timeline(
        "timeline",
        "Stacks over time",
        "Top: the stack that the controller is on or on its way to. Below: from the trigger "
        "until the stack was taken over.",
        spans,
        grid.span,
    )
