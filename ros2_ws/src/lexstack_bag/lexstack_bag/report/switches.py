"""Figures of the switches: the source's discontinuous solution against the smooth command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from markupsafe import Markup

from lexstack.robots import RobotModel
from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import COMMANDER
from lexstack_bag.report.figure import Figure, letters
from lexstack_bag.report.layout import grid as grid_layout
from lexstack_bag.report.layout import vertical
from lexstack_bag.report.traces import JOINTS, Grid, Plain, line
from lexstack_bag.run.partial_chi import joined
from lexstack_bag.run.run import Run

SOURCE = "robot_b"  # whose chi is the target of a transition
_BASE = 3  # colours that bases have for themselves
_TITLE = Markup("{} {} → {}: χ<sub>B</sub> and the command")
_CAPTION = Markup(
    "Fig. {} of the paper. Dashed: χ<sub>B</sub>, the solver's solution of <b>{}</b>, which "
    "jumps at the trigger (solid vertical line). Solid: the command, which goes to it smoothly; "
    "where the dotted line stands, the controller has taken the stack over."
)
_BEFORE, _AFTER = 0.4, 0.8  # s, shown around the blend
_MOST = 8  # switches that are drawn: keeps the file of a long run small


def switches(run: Run, phases: Sequence[Phase], grid: Grid) -> list[Figure]:
    """Return one figure for every switch, as the paper's Figs. 6 to 8."""
    entries = list(zip(letters(phases), phases, phases[1:], strict=False))
    figures = [_switch(run, label, before, phase, grid) for label, before, phase in entries[:_MOST]]
    if len(entries) > _MOST:
        more = f" The {len(entries) - _MOST} switches after it are not drawn."
        figures[-1] = replace(figures[-1], caption=figures[-1].caption + more)
    return figures


def _switch(run: Run, label: str, before: Phase, phase: Phase, grid: Grid) -> Figure:
    """Return the figure of one switch."""
    arrival = phase.end if phase.adopted is None else phase.adopted
    # Where the solver is not followed to the end of a blend, two seconds show what happens.
    span = phase.start - _BEFORE, min(arrival + _AFTER, phase.end, phase.start + 4.0)
    team = run.team()
    parts, units = team.slices, [speed for robot in team.robots for speed in _speeds(robot)]
    traces: list[Plain] = []
    for column, (robot, part) in enumerate(zip(team.robots, parts, strict=True)):
        names = [joint.removeprefix("base_") for joint in robot.joints[robot.base]]
        called = (*names, *(f"joint {k + 1}" for k in range(robot.n - len(names))))
        for row, own in enumerate((robot.base, robot.arm)):
            entries = [
                (joint, name, JOINTS[(row * _BASE + k) % len(JOINTS)])
                for k, (joint, name) in enumerate(
                    zip(range(part.start, part.stop)[own], called[own], strict=True)
                )
            ]
            style = {"row": row * len(parts) + column + 1, "legend": column == 0}
            traces += _solutions(run, entries, units, span, grid, style)
    lines = [(phase.start, "solid"), (phase.adopted, "dot")]
    shapes = [
        vertical(time, f"x{column + 1}" if column else "x", dash)
        for column in range(len(parts))
        for time, dash in lines
        if time is not None
    ]
    titles = [
        ["base χ [m/s, rad/s]"] * len(parts),
        [f"arm χ [{', '.join(_arm_units(robot))}]" for robot in team.robots],
    ]
    return Figure(
        f"switch-{label.strip('()').lower()}",
        _TITLE.format(label, before.stack, phase.title),
        _CAPTION.format(_paper_figure(label), phase.title),
        traces,
        grid_layout(titles, run.robots, 210, span, shapes),
        linked=False,
    )


def _solutions(
    run: Run,
    entries: Sequence[tuple[int, str, str]],
    units: Sequence[str],
    span: tuple[float, float],
    grid: Grid,
    where: dict[str, Any],
) -> list[Plain]:
    """Return chi_B dashed and the command solid for some entries of chi.

    Args:
        run: that was recorded.
        entries: places in chi, with their names and colours.
        units: of all entries of chi.
        span: of time [s].
        grid: of the times.
        where: the plot, and whether its lines are in the legend.
    """
    command = run.chi[COMMANDER]
    source = joined(run, SOURCE) if SOURCE in run.chi else None
    traces: list[Plain] = []
    for joint, name, color in entries:
        style: dict[str, Any] = where | {"unit": units[joint]}
        if source is not None and np.any((source.stamp >= span[0]) & (source.stamp <= span[1])):
            series = grid.window(source.tick, source.chi[:, joint], *span)
            dashed = {"legendgroup": name, "showlegend": False}
            traces.append(
                line(series, f"{name}, χ_B", color, dash="dash", width=1.3, **style) | dashed
            )
        series = grid.window(command.tick, command.chi[:, joint], *span)
        traces.append(line(series, name, color, width=1.8, **style))
    return traces


def _speeds(robot: RobotModel) -> list[str]:
    """Return the unit of each joint's velocity."""
    return ["m/s" if slides else "rad/s" for slides in robot.prismatic]


def _arm_units(robot: RobotModel) -> list[str]:
    """Return the units of an arm's velocities, each once."""
    return sorted(set(_speeds(robot)[robot.arm]))


def _paper_figure(label: str) -> str:
    """Return the number of the paper's figure of a switch; it has three."""
    return {"(A)": "6", "(B)": "7", "(C)": "8"}.get(label, "6 to 8")
