"""Runs the programs of examples/ and draws what came out, into docs/images/examples.

Run by `./scripts/gallery --examples`, for all programs or those that are named. On the left the
robots in MuJoCo, on the right what the program is about.
"""

from __future__ import annotations

import contextlib
import io
import runpy
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from lexstack import Obstacles, Pose, Team
from lexstack_sim.render import Renderer

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "images" / "examples"
BLUE, ORANGE, GREEN, GREY = "#0072b2", "#d55e00", "#009e73", "#777777"  # Okabe and Ito
COLORS = 192  # of a picture: small files, and no difference to see
AXES = "xyz"

Values = Mapping[str, Any]
"""The names of a program after it has run."""
Draw = Callable[[Axes, Values], None]


def own_arm(axes: Axes, values: Values) -> None:
    """Draw where the hand went, and its target."""
    path = np.array(values["path"])
    _coordinates(axes, values["dt"] * np.arange(len(path)), path, values["place"].goal.position)


def differential_drive(axes: Axes, values: Values) -> None:
    """Draw the way of the base from above, with its heading now and then, and the hand."""
    record = values["record"]
    x, y, yaw = record.q[:, :3].T
    axes.plot(x, y, color=ORANGE, label="base")
    some = slice(None, None, 60)
    arrows = (x[some], y[some], np.cos(yaw[some]), np.sin(yaw[some]))
    axes.quiver(*arrows, color=ORANGE, scale=16, width=0.004)
    hand = record.path("panda_hand")
    axes.plot(hand[:, 0], hand[:, 1], "o", color=BLUE, label="hand")
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


def carry_a_box(axes: Axes, values: Values) -> None:
    """Draw how the hands rose, and their distance to each other."""
    time, hands, apart = values["record"].time, values["hands"], values["apart"]
    for hand, name, color in zip(hands, ("left", "right"), (BLUE, ORANGE), strict=True):
        axes.plot(time, hand[:, 2] - hand[0, 2], color=color, label=f"{name} hand rose [m]")
    axes.plot(time, apart - apart[0], color=GREEN, label="change of their distance [m]")
    _timed(axes)


def teleoperation(axes: Axes, values: Values) -> None:
    """Draw the hand's speed, and when the stream broke."""
    axes.plot(values["record"].time[1:], values["speed"], color=BLUE, label="speed of the hand")
    axes.axvline(2.24, color=GREY, ls=":", label="last twist")
    axes.set_ylabel("m/s")
    _timed(axes)


def figure_of_eight(axes: Axes, values: Values) -> None:
    """Draw the way from above."""
    record, eight = values["run"].record(), values["eight"]
    path = record.path("tool0")
    asked = np.array([eight.at(time).position for time in record.time])
    axes.plot(asked[:, 1], asked[:, 0], color=GREY, lw=4, alpha=0.4, label="asked for")
    for begin, end, color, text in (
        (0.0, 6.0, BLUE, "first stack"),
        (6.0, 8.0, ORANGE, "in transition"),
        (8.0, 99.0, GREEN, "second stack"),
    ):
        part = (record.time >= begin) & (record.time < end)
        axes.plot(path[part, 1], path[part, 0], color=color, label=text)
    axes.set(xlabel="y [m]", ylabel="x [m]", aspect="equal", xlim=(-0.15, 0.4))


def obstacle(axes: Axes, values: Values) -> None:
    """Draw the room between hand and ball, and how far the hand gave way."""
    time, path = values["record"].time, values["path"]
    axes.plot(time, values["room"], color=BLUE, label="room between hand and ball")
    axes.axhline(0.05, color=GREY, ls=":", label="asked for")
    axes.plot(time, np.linalg.norm(path - path[0], axis=1), color=ORANGE, label="hand gave way")
    axes.set(ylabel="m", ylim=(0.0, 0.4))
    _timed(axes)


def switch_and_preempt(axes: Axes, values: Values) -> None:
    """Draw all velocities, and the blends."""
    record = values["record"]
    for begin in (0.8, 1.5):
        axes.axvline(begin, color=GREY, ls=":")
    axes.plot(record.time, record.velocity, lw=1)
    axes.set_ylabel("joint velocities [m/s, rad/s]")
    _timed(axes, legend=False)


def changing_limits(axes: Axes, values: Values) -> None:
    """Draw the velocities and their limits."""
    record = values["record"]
    axes.plot(record.time, record.velocity, lw=1)
    axes.axvline(0.8, color=GREY, ls=":")
    axes.axvline(4.0, color=GREY, ls=":")
    axes.plot([0.8, 10.0], [0.2, 0.2], color=GREY, ls="--")
    axes.plot([0.8, 10.0], [-0.2, -0.2], color=GREY, ls="--")
    axes.set_ylabel("joint velocities [rad/s]")
    _timed(axes, legend=False)


def deliveries(axes: Axes, values: Values) -> None:
    """Draw hand and base from above, with the goals."""
    record = values["run"].record()
    hand = record.path("panda_hand")
    axes.plot(hand[:, 0], hand[:, 1], color=BLUE, label="hand")
    axes.plot(record.q[:, 0], record.q[:, 1], color=ORANGE, label="base")
    for task in values["tasks"]:
        x, y, *_ = task.points[-1]
        axes.plot(x, y, "x", color=BLUE if task.kind.startswith("ee") else ORANGE)
        axes.annotate(task.name, (x, y), (4, 4), textcoords="offset points", fontsize=8)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


def swept_weight(axes: Axes, values: Values) -> None:
    """Draw both errors over the weight, and those of two levels."""
    weights, hand, posture = np.array(values["rows"]).T
    axes.semilogx(weights, hand, "o-", color=BLUE, label="hand off [m]")
    axes.semilogx(weights, posture, "o-", color=ORANGE, label="posture off [rad]")
    for value, color in zip(values["strict"], (BLUE, ORANGE), strict=True):
        axes.axhline(value, color=color, ls="--", lw=1)
    axes.plot([], [], color=GREY, ls="--", lw=1, label="in two levels")
    axes.set_xlabel("weight of the posture")


def own_task(axes: Axes, values: Values) -> None:
    """Draw the tool's height and its way around."""
    _coordinates(axes, values["run"].record().time, values["path"], (np.nan, np.nan, 0.4))


def in_mujoco(axes: Axes, values: Values) -> None:
    """Draw how far the hand is from its target."""
    record, goal = values["run"].record(), values["hand"].goal.position
    off = np.linalg.norm(record.path("hand") - goal, axis=1)
    axes.semilogy(record.time, off, color=BLUE, label="hand to target [m]")
    axes.axvline(3.0, color=GREY, ls=":", label="switch to the posture")
    _timed(axes)


DRAWINGS: dict[str, Draw] = {
    draw.__name__: draw
    for draw in (
        own_arm,
        differential_drive,
        carry_a_box,
        teleoperation,
        figure_of_eight,
        obstacle,
        switch_and_preempt,
        changing_limits,
        deliveries,
        swept_weight,
        own_task,
        in_mujoco,
    )
}
"""What is drawn of each program, by its name."""


def _coordinates(axes: Axes, time: Any, path: Any, goal: Any) -> None:
    """Draw three coordinates over time, and where they shall be."""
    for values, end, name, color in zip(path.T, goal, AXES, (BLUE, ORANGE, GREEN), strict=True):
        axes.plot(time, values, color=color, label=name)
        axes.axhline(end, color=color, ls=":", lw=1)
    axes.set_ylabel("m")
    _timed(axes)


def _timed(axes: Axes, *, legend: bool = True) -> None:
    """Name the time; without a legend where the lines have no names."""
    axes.set_xlabel("time [s]")
    if not legend:
        axes.legend = lambda **_options: None


def _rendered(values: Values) -> Any:
    """Return a picture of the robots at the end, or where it says most, with their target."""
    if "run" in values:
        record, team = values["run"].record(), values["run"].team
        at = {"ball": 300}.get(next((name for name in ("ball",) if name in values), ""), -1)
        q, stamp = record.q[at], record.time[at]
    else:
        robot = values["robot"]
        team, stamp = Team((robot.model,), 0.01, Obstacles({})), 0.0
        q = values.get("q", robot.home)
    goals = [value.goal for value in values.values() if isinstance(getattr(value, "goal", 0), Pose)]
    with Renderer(team, (480, 420)) as renderer:
        renderer.frame([q], goals, azimuth=140.0, elevation=-18.0)
        return renderer.picture(q, dict(zip("abcdef", goals, strict=False)), stamp)


def drawn(name: str) -> Image.Image:
    """Run a program and return its picture."""
    with contextlib.redirect_stdout(io.StringIO()):
        values = runpy.run_path(str(ROOT / "examples" / f"{name}.py"))
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.25))
    left.imshow(_rendered(values))
    left.axis("off")
    DRAWINGS[name](right, values)
    right.grid(alpha=0.3)
    right.legend(fontsize=8)
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=100, metadata={"Software": None})
    return Image.open(buffer).convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)


def write(names: tuple[str, ...] = ()) -> None:
    """Write the pictures of some programs, or of all."""
    mpl.use("agg")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in names or tuple(DRAWINGS):
        path = FOLDER / f"{name}.png"
        drawn(name).save(path, optimize=True)
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")
