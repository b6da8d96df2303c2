"""The difference of a replay, drawn: how far chi is from the recorded one, and where most."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lexstack.types import Vector
from lexstack_bag.replay.outcome import Outcome

mpl.use("Agg")

_RECORDED, _REPLAYED = "#000000", "#D55E00"  # told apart by the colour-blind, and by their dashes
_WIDTH, _HEIGHT = 9.0, 2.2  # inch, of one plot


def draw(outcomes: Sequence[Outcome], title: str, path: Path) -> None:
    """Write a picture with two plots per node and unit; raises OSError.

    Above the largest difference over the joints of that unit, below the joint with the largest
    difference, recorded and replayed.
    """
    plots = [(outcome, unit) for outcome in outcomes for unit in _units(outcome)]
    figure = Figure(figsize=(_WIDTH, _HEIGHT * max(2 * len(plots), 1)), layout="constrained")
    axes = figure.subplots(2 * len(plots), 1, sharex=True, squeeze=False)[:, 0] if plots else []
    for place, (outcome, unit) in enumerate(plots):
        _draw(outcome, unit, axes[2 * place], axes[2 * place + 1])
    if plots:
        axes[-1].set_xlabel("simulated time [s]")
    figure.suptitle(title, fontsize=10)
    figure.savefig(path, dpi=120)


def _units(outcome: Outcome) -> list[str]:
    """Return the units of a node's joints, in their order."""
    return list(dict.fromkeys(joint.unit for joint in outcome.joints)) if len(outcome.tick) else []


def _draw(outcome: Outcome, unit: str, above: Axes, below: Axes) -> None:
    """Draw the joints of one unit."""
    mine = np.flatnonzero([joint.unit == unit for joint in outcome.joints])
    apart = np.abs(outcome.replayed - outcome.recorded)[:, mine]
    known = np.where(np.isfinite(apart), apart, 0.0)
    worst = int(mine[known.max(axis=0).argmax()])
    steps = np.diff(outcome.tick)
    usual = int(steps.min(initial=1 << 62))  # the HTMPC plans every few ticks
    gaps = np.flatnonzero(steps > usual) + 1
    stamp = np.insert(outcome.stamp, gaps, np.nan)  # a line shall not lead across a gap

    def line(axes: Axes, values: Vector, color: str, style: str, label: str) -> None:
        broken = np.insert(values, gaps, np.nan)
        axes.plot(stamp, broken, color=color, linestyle=style, linewidth=1.0, label=label)

    line(above, known.max(axis=1), _REPLAYED, "-", "")
    symbol, what = ("χ", "χ") if outcome.what == "chi" else ("v", outcome.what)
    above.set_ylabel(f"largest |Δ{symbol}| [{unit}]")
    above.set_title(f"{outcome.node}: difference from the recorded {what}", fontsize=9, loc="left")
    first = outcome.first
    if first is not None:
        at = float(outcome.stamp[outcome.tick == first][0])
        above.axvline(at, color="#0072B2", linestyle=":", label=f"first different: tick {first}")
        above.legend(fontsize=8, loc="upper right")
    line(below, outcome.recorded[:, worst], _RECORDED, "-", "recorded")
    line(below, outcome.replayed[:, worst], _REPLAYED, "--", "replayed")
    below.set_ylabel(f"{symbol} [{unit}]")
    below.set_title(f"{outcome.node}: {outcome.joints[worst].name}", fontsize=9, loc="left")
    below.legend(fontsize=8, loc="upper right")
    for axes in (above, below):
        axes.grid(visible=True, linewidth=0.4)
