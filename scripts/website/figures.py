"""Draws the figures of the pages of equations, from the library itself, into docs/images/equations.

Run by `./scripts/run python scripts/website/figures.py` when what they show has changed.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from lexstack.hqp import HqpProblem, make_solver
from lexstack.limits import Bounds, JointLimits, viable_bounds
from lexstack.transition import GapMotion, alpha
from lexstack.types import LinearTask

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
    slip = np.full(
        1, -0.4 * np.cos(2.0 * start)
    )  # rad/s^2, the acceleration of the controller less that of the solver
    motion = replace(GapMotion.none(1, duration), acceleration_mismatch=slip)
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


def levels() -> Figure:
    """Return a problem of two joints and two levels, and its optimum."""
    end = np.full(2, 0.5)  # rad/s
    total, wish = 0.8, np.array([0.8, -0.2])  # rad/s
    first = LinearTask.equality("first", np.ones((1, 2)), np.array([total]))
    second = LinearTask.equality("second", np.eye(2), wish)
    problem = HqpProblem(((first,), (second,)), Bounds(-end, end))
    chi = make_solver().solve(problem, None).chi
    figure = Figure(figsize=(4.6, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.add_patch(Rectangle(-end, 1.0, 1.0, color=BLUE, alpha=0.15, label="the box"))
    x = np.array([-0.4, 1.0])
    axes.plot(x, total - x, color=BLUE, label="optima of level 1")
    axes.plot(*wish, "x", color=ORANGE, ms=9, mew=2, label="target of level 2")
    axes.plot(*chi, "o", color=GREEN, ms=8, label="optimum χ")
    axes.plot(*np.array([chi, wish]).T, color=GREY, ls=":")
    axes.set(xlabel="joint 1 [rad/s]", ylabel="joint 2 [rad/s]", aspect="equal")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower left", fontsize=8)
    return figure


def bend() -> Figure:
    """Return a step along the tangent of the set that level 1 leaves, and a bent one."""
    steps = np.linspace(0.0, 1.0, 50)
    angle = np.linspace(-0.2, 1.35, 100)
    figure = Figure(figsize=(5.4, 3.4), layout="constrained")
    axes = figure.subplots()
    circle = np.array([np.sin(angle), np.cos(angle)])
    axes.plot(*circle, color=GREY, label="inputs that keep the error of level 1")
    band = np.concatenate((0.96 * circle, 1.04 * circle[:, ::-1]), axis=1)
    axes.fill(*band, color=GREY, alpha=0.2, label="within δ of it")
    axes.plot(steps, np.ones(50), color=ORANGE, ls="--", label="straight: u + α d")
    axes.plot(steps, 1.0 - 0.5 * steps**2, color=BLUE, label="bent: u + α d + α² b")
    axes.plot(0.0, 1.0, "o", color=BLUE)
    axes.set(xticks=[], yticks=[], aspect="equal")
    axes.legend(loc="lower left", fontsize=8)
    return figure


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


FIGURES = {"viable-box": viable_box, "bridge": bridge, "levels": levels, "bend": bend}
"""How each figure is drawn, by the name of its file."""


def main() -> None:
    """Write all figures."""
    mpl.use("agg")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, draw in FIGURES.items():
        draw().savefig(FOLDER / f"{name}.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
