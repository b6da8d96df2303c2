"""Draws the figures of the pages of equations, from the library itself, into docs/images/equations.

Run by `./scripts/run python scripts/website/figures.py` when what they show has changed.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from lexstack_core.bounds import JointLimits, viable_bounds
from lexstack_core.transition.carry import Carry
from lexstack_core.transition.profile import alpha

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "images" / "equations"
DT = 0.01  # s
BLUE, ORANGE, GREEN, GREY = "#0072b2", "#d55e00", "#009e73", "#777777"  # Okabe and Ito


def viable_box() -> Figure:
    """Return a joint that is asked for its velocity limit, and the box that makes it brake."""
    speed, rate, end = 1.0, 2.5, 0.8  # rad/s, rad/s^2, rad
    one = np.ones(1)
    limits = JointLimits(-9.0 * one, end * one, speed * one, rate * one, np.inf * one)
    q, v = np.zeros(1), np.zeros(1)
    rows = []
    for _ in range(160):
        box = viable_bounds(q, limits, DT, v)
        rows.append((q[0], box.lower[0], box.upper[0], v[0], (end - q[0]) / DT))
        v = box.upper.copy()
        q = q + DT * v
    position, lower, upper, applied, printed = np.array(rows).T
    time = DT * np.arange(len(rows))
    figure, (top, bottom) = _figure(2)
    top.fill_between(time, lower, upper, color=BLUE, alpha=0.25, label="the box, ±aΔt around v")
    top.plot(time, applied, color=BLUE, label="velocity v")
    top.plot(
        time,
        np.minimum(printed, speed),
        color=ORANGE,
        ls="--",
        label="upper end of T(31), position and velocity",
    )
    top.set_ylabel("velocity [rad/s]")
    bottom.plot(time, position, color=BLUE, label="position q")
    bottom.axhline(end, color=GREY, ls=":", label="position limit")
    bottom.set_ylabel("position [rad]")
    return _finished(figure)


def bridge() -> Figure:
    """Return a step from one velocity to another, and the same gap faded by the quintic."""
    start, duration = 0.3, 1.0  # s
    time = np.arange(-0.2, 1.4, DT)
    source = 0.5 + 0.2 * np.sin(2.0 * time)  # rad/s, chi_B
    before = 0.1 + 0.0 * time  # rad/s, chi_A
    rest = np.array([1.0 - alpha("quintic", t - start, duration) for t in time])
    gap = 0.1 - (0.5 + 0.2 * np.sin(2.0 * start))
    command = np.where(time < start, before, source + rest * gap)
    slip = np.full(1, -0.4 * np.cos(2.0 * start))  # rad/s^2, the acceleration of A less that of B
    motion = replace(Carry.none(1, duration), slip=slip)
    carried = np.array([motion.at(t - start)[0] if t >= start else 0.0 for t in time])
    step = np.where(time < start, before, source)
    figure, (top, bottom) = _figure(2)
    top.plot(time, step, color=ORANGE, ls="--", label="a command that steps to χ_B")
    top.plot(time, command, color=BLUE, label="χ_B + (1 − α) δ")
    top.set_ylabel("velocity [rad/s]")
    bottom.plot(time[1:], np.diff(step) / DT, color=ORANGE, ls="--", label="of the step")
    bottom.plot(time[1:], np.diff(command) / DT, color=BLUE, label="of χ_B + (1 − α) δ")
    smooth = np.diff(command + carried) / DT
    bottom.plot(time[1:], smooth, color=GREEN, label="the same, and the motion of the gap")
    bottom.set_ylim(-1.0, 2.0)
    bottom.set_ylabel("acceleration [rad/s²]")
    return _finished(figure)


def _figure(rows: int) -> tuple[Figure, list]:
    """Return a figure with plots above each other that share the time."""
    figure = Figure(figsize=(7.0, 2.2 * rows), layout="constrained")
    return figure, list(figure.subplots(rows, 1, sharex=True))


def _finished(figure: Figure) -> Figure:
    """Return the figure with grid, legends and the time's name."""
    for axes in figure.axes:
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    figure.axes[-1].set_xlabel("time [s]")
    return figure


def main() -> None:
    """Write all figures."""
    mpl.use("agg")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, figure in {"viable-box": viable_box(), "bridge": bridge()}.items():
        figure.savefig(FOLDER / f"{name}.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
