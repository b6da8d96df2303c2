"""Figures of the control: solve times and alpha, smoothness of the command, bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import COMMANDER, TimeSeries
from lexstack_bag.report.figure import Figure
from lexstack_bag.report.layout import level, stacked
from lexstack_bag.report.traces import (
    BLACK,
    BLUE,
    DASHES,
    ORANGE,
    PURPLE,
    ROBOTS,
    SERIES,
    SKY,
    VERMILLION,
    Grid,
    Plain,
    line,
)
from lexstack_bag.run.run import Run, TransitionPhase

_LEAST = 1e-9  # m/s, rad/s: a logarithm has no zero
_UNDER_WAY = (TransitionPhase.PREPARING, TransitionPhase.BLENDING, TransitionPhase.ADOPTING)


def computation(run: Run, phases: Sequence[Phase], grid: Grid) -> Figure:
    """Return the paper's Fig. 9: solve times and alpha; and the gap to the source."""
    traces: list[Plain] = []
    medians = []
    for i, (name, chi) in enumerate(run.chi.items()):
        if not len(chi.tick):
            continue
        milliseconds = 1e3 * chi.solve_time
        medians.append(f"{name} {np.median(milliseconds):.2f} ms")
        color, dash = ROBOTS[i % len(ROBOTS)], DASHES[2 * i % len(DASHES)]
        series = grid.series(chi.tick, milliseconds)
        traces.append(line(series, name, color, dash=dash, unit="ms", width=1.0))
    status = run.transition
    under_way = np.isin(status.phase, _UNDER_WAY)  # at other times neither means anything
    for i, (whose, mine) in enumerate(_transitions(run, under_way)):
        for row, name, color, unit, values in (
            (2, "α", BLACK, "", status.alpha),
            (3, "gap to the source", PURPLE, "m/s, rad/s", status.gap),
        ):
            series = grid.series(status.tick[mine], values[mine])
            dash = DASHES[i % len(DASHES)]
            traces.append(line(series, name + whose, color, row=row, dash=dash, unit=unit))
    return Figure(
        "computation",
        "Solve times, α and the gap",
        "Fig. 9 of the paper. Top: wall-clock time from state to χ in each robot's own process; "
        f"medians: {', '.join(medians) or 'none'}. The solver solves only while a stack is "
        "prepared or blended. Middle: α of the blends. Bottom: the largest difference over the "
        "joints between the command and the source's χ.",
        traces,
        stacked(["solve time [ms]", "α [-]", "gap [m/s, rad/s]"], 160, phases, grid.span),
    )


def _transitions(run: Run, under_way: NDArray[np.bool_]) -> list[tuple[str, Any]]:
    """Return the rows of the transitions that are under way, by the robots that they are about."""
    robots = run.transition.robots
    if not len(robots):
        return [("", under_way)]
    groups = sorted(set(robots[under_way].tolist())) or [""]
    names = {group: f", {group}" if len(groups) > 1 else "" for group in groups}
    return [(names[group], under_way & (robots == group)) for group in groups]


def smoothness(run: Run, time_series: TimeSeries, phases: Sequence[Phase], grid: Grid) -> Figure:
    """Return the command's acceleration and jerk at every tick, over the limits."""
    ticks = run.chi[COMMANDER].tick
    traces: list[Plain] = []
    for row, ratios in enumerate((time_series.acceleration_ratio, time_series.jerk_ratio), start=1):
        known = np.isfinite(ratios).any(axis=1)
        worst = np.full(len(ratios), np.nan)
        worst[known] = np.nanmax(ratios[known], axis=1)
        name, color = ("acceleration", BLUE) if row == 1 else ("jerk", ORANGE)
        traces.append(line(grid.series(ticks, worst), name, color, row=row))
    layout = stacked(["acceleration / limit [-]", "jerk / limit [-]"], 180, phases, grid.span)
    layout["shapes"].append(level(1.0, 1, VERMILLION))
    for key in ("yaxis", "yaxis2"):
        layout[key]["rangemode"] = "tozero"
    return Figure(
        "smoothness",
        "Smoothness of the command",
        Markup(
            "The largest |χ(k) − χ(k−1)| / (Δt·q̈<sub>max</sub>) over all joints, and the same for "
            "jerk. The dashed line is the acceleration limit. Jerk is bounded only where jerk "
            "limits are on."
        ),
        traces,
        layout,
    )


def levels(run: Run, phases: Sequence[Phase], grid: Grid) -> Figure | None:
    """Return the residual of every level of the stack that was solved; None without any."""
    command = run.chi[COMMANDER]
    slacks = np.asarray(command.slacks)
    if not slacks.size:
        return None
    traces = [
        line(
            grid.series(command.tick, np.maximum(slacks[:, k], _LEAST)),
            f"level {k + 1}",
            SERIES[k % len(SERIES)],
            dash=DASHES[k % len(DASHES)],
            unit="m/s, rad/s",
        )
        for k in range(slacks.shape[1])
    ]
    layout = stacked(["residual [m/s, rad/s]"], 300, phases, grid.span)
    layout["yaxis"] |= {"type": "log", "dtick": 2, "exponentformat": "power"}
    return Figure(
        "levels",
        "What each level leaves",
        "The 2-norm of the residual of each level in the controller's problem, level 1 first, "
        "in the units of the level's tasks. While a blend runs these are the levels of the blend. "
        "Values below 1e-9 are drawn there.",
        traces,
        layout,
    )


def bounds(run: Run, phases: Sequence[Phase], grid: Grid) -> Figure:
    """Return command, measured velocity and bounds of any one joint."""
    command, plant = run.chi[COMMANDER], run.plant
    traces: list[Plain] = []
    choices = joints(run)
    for joint in range(len(choices)):
        unit = choices[joint].partition("[")[2].rstrip("]")
        style: dict[str, Any] = {"visible": joint == 0, "unit": unit}
        lower = grid.series(command.tick, command.lower[:, joint])
        upper = grid.series(command.tick, command.upper[:, joint])
        fill: dict[str, Any] = {"fill": "tonexty", "fillcolor": "rgba(86, 180, 233, 0.28)"}
        measured = grid.series(plant.tick, plant.v[:, joint])
        traces += [
            line(lower, "lower bound", SKY, width=0.8, legend=False, **style),
            line(upper, "bounds on χ", SKY, width=0.8, **fill, **style),
            line(measured, "measured", ORANGE, dash="dot", width=1.6, **style),
            line(grid.series(command.tick, command.chi[:, joint]), "command", BLUE, **style),
        ]
    return Figure(
        "bounds",
        "Command and bounds of one joint",
        "Shaded: from the lower to the upper bound on χ at each tick, made from position, "
        "velocity and acceleration limits together. The command stays inside.",
        traces,
        stacked(["joint velocity [m/s, rad/s]"], 320, phases, grid.span),
        choices=choices,
    )


def joints(run: Run) -> tuple[str, ...]:
    """Return a label for every entry of chi, with its unit, by the joint's type."""
    labels = []
    for robot in run.team().robots:
        for place, (joint, slides) in enumerate(zip(robot.joints, robot.prismatic, strict=True)):
            arm = place - robot.base.stop
            name = f"arm joint {arm + 1} ({joint})" if arm >= 0 else joint.replace("_", " ")
            labels.append(f"{robot.name} {name} [{'m/s' if slides else 'rad/s'}]")
    return tuple(labels)
