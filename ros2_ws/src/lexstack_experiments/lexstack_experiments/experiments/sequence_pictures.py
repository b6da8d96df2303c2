"""Pictures of the task sequence like T's Figs. 5 to 8."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from lexstack.types import Matrix, Vector
from lexstack_bag.figures.figures import Analysis
from lexstack_bag.figures.phases import BASE_TASKS, tasks_of
from lexstack_experiments.loop import Loop
from lexstack_experiments.pictures import (
    COLOURS,
    few_ticks,
    legend_beside,
    mark,
    picture,
    share_height,
)

_NAMES = ("A", "B", "C")
_BEFORE, _AFTER = 0.25, 2.0  # s around a switch that its picture shows
_MOST = 6  # joints in a picture of a switch: those that move most


def draw(loop: Loop, measured: Analysis, out: Path) -> None:
    """Write fig5.png, and one picture for each switch, fig6.png to fig8.png."""
    switches = [phase.start for phase in measured.phases[1:]]
    times = dict(zip(_NAMES, switches, strict=False))
    _motion(measured, {f"({name})": time for name, time in times.items()}, out / "fig5.png")
    for number, name in zip((6, 7, 8), times, strict=False):
        _switch(loop, name, times[name], out / f"fig{number}.png", side_by_side=number == 8)


def _motion(measured: Analysis, times: dict[str, float], path: Path) -> None:
    """Draw end effectors against their references, then the bases, T Fig. 5."""
    time_series, robots = measured.time_series, measured.run.robots
    asked = np.zeros(time_series.time.shape, dtype=np.bool_)
    for phase in measured.phases:
        if tasks_of(measured.run, phase.stack, BASE_TASKS):
            asked |= phase.ticks(time_series.time)
    base_target = np.where(asked[:, None, None], time_series.base_target, np.nan)
    tool, base = "end effector [m]", "base [m, rad]"
    panels = [
        (f"{name}: {what}", actual[:, i], target[:, i], names)
        for what, actual, target, names in (
            (tool, time_series.ee, time_series.ee_target, ("x", "y", "z")),
            (base, time_series.base, base_target, ("x", "y", "yaw")),
        )
        for i, name in enumerate(robots)
    ]
    with picture(path, len(panels), 1, (7.0, 1.6 * len(panels))) as axes:
        for panel, (title, actual, desired, names) in zip(axes, panels, strict=True):
            for k, name in enumerate(names):
                panel.plot(time_series.time, actual[:, k], color=COLOURS[k], label=name)
                panel.plot(time_series.time, desired[:, k], "--", color=COLOURS[k], linewidth=0.9)
            panel.set_title(f"{title}, dashed: reference", loc="left")
            legend_beside(panel)
            mark(panel, times)
            few_ticks(panel)
        axes[-1].set_xlabel("time [s]")


def _switch(loop: Loop, name: str, start: float, path: Path, *, side_by_side: bool) -> None:
    """Draw the solver's chi and the controller's command around a switch, T Figs. 6 to 8."""
    team, rate = loop.parts.team, loop.resolved.scenario.rate
    first, last = round((start - _BEFORE) * rate), round((start + _AFTER) * rate)
    commands = loop.record.commands[first:last]
    time = np.array([command.stamp for command in commands])
    command = np.array([command.chi for command in commands])
    source = np.array([_source(loop, command.tick) for command in commands])
    columns = 2 if side_by_side else 1
    with picture(path, len(team.names), columns, (7.0, 2.4 * len(team.names))) as axes:
        for robot, part in enumerate(team.slices):
            here = axes[columns * robot : columns * (robot + 1)]
            labels = _labels(team.robots[robot].joints)
            for k, joint in enumerate(_busiest(source[:, part], command[:, part])):
                style = "-" if side_by_side else "--"
                here[0].plot(time, source[:, part][:, joint], style, color=COLOURS[k])
                here[-1].plot(
                    time, command[:, part][:, joint], color=COLOURS[k], label=labels[joint]
                )
            _finish(here, team.names[robot], {f"({name})": start})
        for panel in axes[-columns:]:
            panel.set_xlabel("time [s]")


def _finish(panels: list[Axes], robot: str, times: dict[str, float]) -> None:
    """Name one robot's panels: both curves in one, or the solver's left and the command right."""
    if len(panels) == 1:
        panels[0].set_title(f"{robot}: dashed χ_B, solid χ [m/s, rad/s]", loc="left")
    else:
        panels[0].set_title(f"{robot}: χ_B [m/s, rad/s]", loc="left")
        panels[1].set_title(f"{robot}: χ", loc="left")
    share_height(panels)
    for panel in panels:
        panel.set_xlim(panels[-1].get_xlim())
        mark(panel, times)
        few_ticks(panel)
    legend_beside(panels[-1])


def _source(loop: Loop, tick: int) -> Vector:
    """Return the solver's chi of a tick, nan where it was not asked."""
    return loop.record.sources.get(tick, np.full(loop.parts.team.n, np.nan))


def _busiest(source: Matrix, command: Matrix) -> list[int]:
    """Return the joints that move most, in their order."""
    most = np.nanmax(np.abs(np.vstack([source, command])), axis=0)
    return sorted(np.argsort(-most)[:_MOST].tolist())


def _labels(joints: tuple[str, ...]) -> list[str]:
    """Return short names: the base's axes, then the arm's joints by number."""
    return ["base x", "base y", "base yaw", *(f"joint {i + 1}" for i in range(len(joints) - 3))]
