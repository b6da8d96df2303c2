"""Pictures of the experiments of paper H."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lexstack.types import Matrix, Vector
from lexstack_experiments.experiments.htmpc_runs import WITHIN, Wave
from lexstack_experiments.experiments.htmpc_sequences import Trip
from lexstack_experiments.pictures import COLOURS, from_above, legend_beside, mark, picture

_DPI = 110
_PARTS = ("#56b4e9", "#0072b2")  # part 1 light, part 2 dark, as in the paper
_PEOPLE = {"red": "#d55e00", "blue": "#0072b2", "yellow": "#e6c200"}


def draw_constraints(curves: Mapping[str, Mapping[str, Wave]], half: float, path: Path) -> None:
    """Write H Fig. 5: the base error over time, a panel for each set of weights."""
    with picture(path, len(curves), 1, (7.2, 0.4 + 1.6 * len(curves))) as axes:
        for panel, (name, waves) in zip(axes, curves.items(), strict=True):
            for k, (label, wave) in enumerate(waves.items()):
                line = "-" if k % 2 else "--"  # low tolerance dashed
                colour = COLOURS[k // 2]
                panel.plot(wave.times, wave.base, line, color=colour, label=label)
            one = next(iter(waves.values()))
            for begin, optimum in ((0.0, one.optimum), (half, 0.0)):
                panel.fill_between(
                    (begin, begin + half), optimum - WITHIN, optimum + WITHIN, color="#d55e0030"
                )
            panel.set_ylim(-0.08, 1.15)
            panel.set_title(f"{name}: base error / initial error", loc="left")
            mark(panel, {"part 2": half})
            legend_beside(panel)
        axes[-1].set_xlabel("time [s]")


def draw_waves(waves: Mapping[str, Wave], half: float, path: Path) -> None:
    """Write H Fig. 4: base and tool errors of the example over time, a curve for each way."""
    with picture(path, 2, 1, (7.2, 3.6)) as axes:
        for k, (name, wave) in enumerate(waves.items()):
            axes[0].plot(wave.times, wave.base, color=COLOURS[k], label=name)
            axes[1].plot(wave.times, wave.tool, color=COLOURS[k])
        axes[0].set_title("base error / initial error", loc="left")
        axes[1].set_title("tool off its place [mm]", loc="left")
        axes[1].set_yscale("symlog", linthresh=1.0)
        legend_beside(axes[0])
        for panel in axes:
            mark(panel, {"part 2": half})
        axes[-1].set_xlabel("time [s]")


def draw_paths(waves: Sequence[Wave], peaks: Matrix, tool: Vector, path: Path) -> None:
    """Write H Fig. 3: the peaks around the tool, and where the base went."""
    with picture(path, 1, 1, (4.6, 4.6)) as axes:
        panel = axes[0]
        for wave in waves:
            panel.plot(wave.path[:, 0], wave.path[:, 1], color=COLOURS[0], linewidth=0.7)
        panel.plot(peaks[:, 0], peaks[:, 1], "*", color=COLOURS[4], label="peaks")
        panel.plot(0.0, 0.0, "o", color=COLOURS[2], label="valley: home of the base")
        panel.plot(tool[0], tool[1], "x", color=COLOURS[1], label="tool")
        from_above(panel)
        panel.legend(loc="upper left")


def draw_violins(parts: Mapping[str, Matrix], path: Path) -> None:
    """Write H Fig. 6: integrals of both parts over the cases, (cases, 2) for each way."""
    with picture(path, 1, 1, (8.0, 3.2)) as axes:
        panel = axes[0]
        for i, values in enumerate(parts.values()):
            for part in (0, 1):
                place = i + (-0.2, 0.2)[part]
                _violin(panel, place, values[:, part], _PARTS[part])
        panel.set_xticks(range(len(parts)), list(parts))
        panel.set_title("mean base error / initial error: part 1 light, part 2 dark", loc="left")
        panel.set_ylim(bottom=0.0)


def _violin(panel: Axes, place: float, values: Vector, colour: str) -> None:
    """Draw one violin and its points."""
    if len(values) > 1 and np.ptp(values) > 0.0:
        shape = panel.violinplot(values, [place], widths=0.36, showextrema=False)
        for body in shape["bodies"]:
            body.set_facecolor(colour)
            body.set_alpha(0.35)
    panel.plot(np.full(len(values), place), values, ".", color=colour, markersize=3)
    panel.plot(place, values.mean(), "_", color="black", markersize=12)


def draw_radial(maps: Mapping[str, Vector], directions: Vector, path: Path) -> None:
    """Write H Fig. 7: the error of part 2 over the direction of the peak from the tool [rad]."""
    order = np.argsort(directions)
    highest = max(float(values.max()) for values in maps.values())
    with mpl.rc_context({"font.size": 7}):
        figure = Figure(figsize=(2.2 * len(maps), 2.7), layout="constrained")
        grid = figure.subplots(1, len(maps), squeeze=False, subplot_kw={"projection": "polar"})
        for panel, (name, values) in zip(grid.flat, maps.items(), strict=True):
            colours = mpl.colormaps["viridis"](values[order] / highest)
            panel.bar(directions[order], values[order], width=0.18, color=colours)
            panel.set_ylim(0.0, highest)
            panel.set_title(name)
            panel.set_yticks([highest / 2.0, highest], [f"{highest / 2.0:.2f}", f"{highest:.2f}"])
            panel.set_xticks(np.arange(4) * np.pi / 2.0)
        figure.savefig(path, dpi=_DPI, metadata={"Software": None}, pil_kwargs={"optimize": True})


def draw_tracks_from_above(
    paths: Mapping[str, Matrix], places: Mapping[str, tuple[float, float]], path: Path
) -> None:
    """Write base paths from above, (m, 2) for each name, and named places [m]."""
    with picture(path, 1, 1, (6.0, 4.2)) as axes:
        panel = axes[0]
        for k, (name, points) in enumerate(paths.items()):
            panel.plot(points[:, 0], points[:, 1], color=COLOURS[k % len(COLOURS)], label=name)
        for name, place in places.items():
            panel.plot(*place, "o", color="black", markersize=4)
            panel.annotate(f" {name}", place)
        from_above(panel)
        legend_beside(panel)


def draw_deliveries(
    paths: Mapping[str, Matrix],
    people: Mapping[str, tuple[Vector, Vector]],
    done: Mapping[str, Mapping[str, float]],
    path: Path,
) -> None:
    """Write H Fig. 9: base paths from above, and the timelines of the tasks.

    Args:
        paths: of the base, (m, 2) for each architecture.
        people: station and place of the tool, shapes (2,), by name, which is a colour.
        done: when each task was done [s], by its name, which begins with the person's, for each
            architecture.
        path: of the file.
    """
    with picture(path, 1, 2, (8.0, 3.0)) as (above, lines):
        for k, (name, points) in enumerate(paths.items()):
            above.plot(points[:, 0], points[:, 1], color=COLOURS[k], linewidth=0.8, label=name)
        for name, (station, place) in people.items():
            colour = _PEOPLE[name]
            above.plot(*station, "s", color=colour, markersize=5)
            above.plot(*place, "o", color=colour, markersize=5)
        from_above(above)
        above.set_title("base; stations square, tool round", loc="left")
        above.legend(loc="lower left")
        for row, (_, tasks) in enumerate(done.items()):
            begin = 0.0
            for task, end in tasks.items():
                low = row + (0.0 if "give" in task else -0.3)
                colour = _PEOPLE[task.split()[0]]
                lines.broken_barh([(begin, end - begin)], (low, 0.3), color=colour)
                begin = end
        lines.set_yticks(range(len(done)), list(done))
        lines.invert_yaxis()
        lines.set_xlabel("time [s]")
        lines.set_title("first task: base above the line, tool below", loc="left")


def draw_reactions(
    trips: Mapping[str, tuple[Trip, Vector, Mapping[str, float]]], delta: float, path: Path
) -> None:
    """Write the tool's error and the base's speed over time, a column for each kind of change.

    Args:
        trips: the trip, the tool's place (3,), and what happens when [s], by kind.
        delta: tolerance of H(13) [mm].
        path: of the file.
    """
    with picture(path, 2, len(trips), (8.0, 3.6)) as axes:
        for k, (kind, (trip, place, events)) in enumerate(trips.items()):
            upper, lower = axes[k], axes[len(trips) + k]
            times = trip.record.times
            shown = times <= events["release"] + 1e-9
            upper.plot(times[shown], 1e3 * trip.off(place)[shown], color=COLOURS[0])
            upper.axhline(delta, color=COLOURS[1], linewidth=0.8)
            upper.set_yscale("log")
            upper.set_xlim(0.0, times[-1])
            upper.set_title(f"{kind}: tool off its place [mm]", loc="left")
            speeds = np.linalg.norm(trip.record.v[:, :2], axis=1)
            lower.plot(times, speeds, color=COLOURS[0])
            lower.set_xlim(0.0, times[-1])
            lower.set_title("speed of the base [m/s]", loc="left")
            lower.set_xlabel("time [s]")
            for panel in (upper, lower):
                mark(panel, dict(events))


def draw_gaps(shares: Mapping[str, Vector], path: Path) -> None:
    """Write how gaps are distributed: the share of states with at most this gap, a curve a row."""
    with picture(path, 1, 1, (8.0, 3.0)) as (panel,):
        for k, (name, values) in enumerate(shares.items()):
            if len(values):
                part = np.arange(1, len(values) + 1) / len(values)
                line = "-" if name.endswith("3") else "--"
                panel.plot(np.sort(values), part, line, color=COLOURS[k // 2], label=name)
        panel.set_xscale("symlog", linthresh=1e-3)
        panel.set_xlabel("cost above the optimum, of what there was to gain")
        panel.set_title("share of states; level, guess, iterations", loc="left")
        legend_beside(panel)


def draw_times(curves: Mapping[str, Mapping[str, Sequence[tuple[int, float]]]], path: Path) -> None:
    """Write solve times over N: points N and median [ms] for each curve, a panel a robot."""
    names = sorted({name for each in curves.values() for name in each})
    with picture(path, 1, len(curves), (8.0, 3.0)) as axes:
        for panel, (robot, each) in zip(axes, curves.items(), strict=True):
            for name, points in each.items():
                line = "--" if name.endswith("spheres") else "-"
                colour = COLOURS[names.index(name)]
                panel.plot(*zip(*points, strict=True), f"o{line}", color=colour, label=name)
            panel.set_yscale("log")
            panel.set_xlabel("N")
            panel.set_title(f"{robot}: median [ms]", loc="left")
        legend_beside(axes[-1])
