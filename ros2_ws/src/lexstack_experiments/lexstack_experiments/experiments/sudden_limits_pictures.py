"""A joint whose limit jumps behind it, under several laws: T Fig. 1 as curves."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from lexstack_experiments.experiments.sudden_limits_runs import Play
from lexstack_experiments.pictures import (
    COLOURS,
    few_ticks,
    legend_beside,
    mark,
    picture,
    share_height,
)

_BEFORE, _AFTER = 0.2, 1.3  # s around the trigger
_SHOWN = ("ours", "ours, within 1 s", "T(31), brake", "T(31), give way", "T(34) last box, brake")


def draw(plays: Mapping[str, Play], path: Path) -> None:
    """Draw position and velocity of the joint that is furthest outside, a column for each law.

    Args:
        plays: the same case under each law, by name.
        path: of the PNG file.
    """
    shown = {name: plays[name] for name in _SHOWN if name in plays}
    first = next(iter(shown.values()))
    joint = int(np.argmax(first.outside()[0]))
    with picture(path, 2, len(shown), (2.2 * len(shown) + 0.8, 4.0)) as axes:
        for k, (name, play) in enumerate(shown.items()):
            _position(axes[k], play, joint)
            _velocity(axes[len(shown) + k], play, joint)
            axes[k].set_title(name, loc="left")
        for row in (axes[: len(shown)], axes[len(shown) :]):
            share_height(row)
            for panel in row:
                few_ticks(panel)
            for panel in row[1:]:
                panel.set_yticklabels([])
            legend_beside(row[-1])
        axes[0].set_ylabel("q* [rad]")
        axes[len(shown)].set_ylabel("χ [rad/s]")


def _span(play: Play) -> tuple[slice, np.ndarray, float]:
    """Return the ticks of the picture, their times and the time of the trigger [s]."""
    rate = play.loop.resolved.scenario.rate
    first = play.trigger - round(_BEFORE * rate)
    last = play.trigger + round(_AFTER * rate)
    return slice(first, last), np.arange(first, last) / rate, play.trigger / rate


def _position(panel: Axes, play: Play, joint: int) -> None:
    """Draw a joint's position, its new limits, and the limit in force."""
    ticks, time, trigger = _span(play)
    new, inside = play.new, (play.least()[joint] + play.trigger) * play.loop.parts.dt
    lower, upper = (
        np.array([getattr(limits, name)[joint] for limits in play.law.limits])[ticks]
        for name in ("position_lower", "position_upper")
    )
    panel.fill_between(time, lower, upper, color=COLOURS[5], alpha=0.3, label="limits in force")
    for limit in (new.position_lower[joint], new.position_upper[joint]):
        panel.axhline(limit, color=COLOURS[1], linewidth=0.9, linestyle="--")
    panel.plot(time, play.q[ticks, joint], color=COLOURS[0], label="q*")
    panel.plot([], [], "--", color=COLOURS[1], linewidth=0.9, label="new limits")
    low, high = play.q[ticks, joint].min(), new.position_lower[joint]
    panel.set_ylim(low - 0.1, high + 0.8)
    mark(panel, {"(A)": trigger, "least": inside})


def _velocity(panel: Axes, play: Play, joint: int) -> None:
    """Draw a joint's command in its box, and the ticks at which the box was empty."""
    ticks, time, trigger = _span(play)
    commands = play.loop.record.commands[ticks]
    lower = np.array([command.bounds.lower[joint] for command in commands])
    upper = np.array([command.bounds.upper[joint] for command in commands])
    panel.fill_between(time, lower, upper, color=COLOURS[5], alpha=0.5, label="box")
    panel.plot(time, play.chi[ticks, joint], color=COLOURS[0], label="χ")
    empty = np.isin(np.arange(ticks.start, ticks.stop), play.empty_ticks())
    if empty.any():
        level = np.full(int(empty.sum()), upper.min())
        panel.plot(time[empty], level, "|", color=COLOURS[1], markersize=5, label="empty box")
    panel.set_xlabel("time [s]")
    mark(panel, {"(A)": trigger})
