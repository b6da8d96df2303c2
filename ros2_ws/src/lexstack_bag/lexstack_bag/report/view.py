"""The run in three dimensions: what the viewer in the page plays, as plain data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from lexstack.robots import to_quaternion
from lexstack.types import Vector
from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.report.figure import letters
from lexstack_bag.report.html import json_text, render
from lexstack_bag.report.traces import ROBOTS, Plain, packed
from lexstack_bag.run.run import Run, TransitionPhase

_MOST_FRAMES = 6000  # 100 a second for a minute; the viewer goes evenly from one to the next
_MOST_POINTS = 3000  # of a path
_MOST_MARKS = 20
_MARGIN = np.array([0.5, 0.5, 0.1])  # m, around tools and bases


def view(run: Run, time_series: TimeSeries, phases: Sequence[Phase]) -> tuple[Markup, str]:
    """Return the section with the 3-D view and its data, or a note, and why there is no view.

    The robots' shapes come from the simulation package; a report can do without.
    """
    try:
        from lexstack_sim.scene import scene  # noqa: PLC0415 - optional, and slow to load

        shapes = scene(run.team())
    except Exception as error:  # noqa: BLE001 - whatever keeps it from working, the rest stands
        reason = f"{type(error).__name__}: {' '.join(str(error).split()) or 'no message'}"
        return render("view.html", reason=reason), reason
    data = json_text({"scene": shapes, **play_data(run, time_series, phases)})
    return render("view.html", reason="", data=data), ""


def play_data(run: Run, time_series: TimeSeries, phases: Sequence[Phase]) -> Plain:
    """Return the frames, paths and marks of a run for ``player.js``."""
    count = len(time_series.time)
    rows = np.unique(np.linspace(0, count - 1, min(count, _MOST_FRAMES)).round().astype(int))
    obstacles = run.team().obstacles
    centers = np.array([obstacles.at(float(time)) for time in time_series.time[rows]])
    frames = {
        "time": time_series.time[rows],
        "q": run.plant.q[rows],
        "obstacles": centers,
        "alpha": _alpha(run, time_series.time[rows]),
    }
    switches = list(zip(letters(phases), phases[1:], strict=True))[:_MOST_MARKS]
    return {
        "frames": {name: packed(values) for name, values in frames.items()},
        "targets": _targets(time_series),
        "paths": _paths(time_series),
        "radii": obstacles.radii.tolist(),
        "box": _box(time_series),
        "marks": [{"label": k, "time": phase.start, "name": phase.title} for k, phase in switches],
        "stacks": [{"name": phase.title, "start": phase.start} for phase in phases],
    }


def _targets(time_series: TimeSeries) -> Plain:
    """Return position and quaternion of the end effectors' references, 7 N, from what time on."""
    changed = [0]
    for i, now in enumerate(time_series.references):
        if now is not time_series.references[changed[-1]]:  # they stay one object while they hold
            changed.append(i)
    stride = -(-len(changed) // _MOST_FRAMES)  # of targets that move all the time
    rows = changed[::stride]
    poses = [
        np.concatenate([[*pose.position, *to_quaternion(pose.rotation)] for pose in now.ee])
        for now in (time_series.references[row] for row in rows)
    ]
    return {"from": packed(time_series.time[rows]), "poses": packed(np.array(poses))}


def _alpha(run: Run, times: Vector) -> Vector:
    """Return alpha at these times [s]; nan while nothing is blended."""
    status = run.transition
    if not len(status.stamp):
        return np.full(len(times), np.nan)
    last = np.searchsorted(status.stamp, times + 1e-6, "right") - 1
    blending = (last >= 0) & (status.phase[last] == TransitionPhase.BLENDING)
    return np.where(blending, status.alpha[last], np.nan)


def _paths(time_series: TimeSeries) -> list[Plain]:
    """Return the lines that tools and bases went along."""
    stride = -(-len(time_series.time) // _MOST_POINTS)
    paths = []
    for i in range(time_series.ee.shape[1]):
        base = time_series.base[::stride, i].copy()
        base[:, 2] = 0.005  # m, above the floor
        paths.append(
            {"color": ROBOTS[i % len(ROBOTS)], "points": packed(time_series.ee[::stride, i])}
        )
        paths.append({"color": "#333333", "points": packed(base)})
    return paths


def _box(time_series: TimeSeries) -> list[list[float]]:
    """Return the lower and upper corner [m] of what the robots reach."""
    base = time_series.base.reshape(-1, 3) * (1, 1, 0)
    points = np.concatenate([time_series.ee.reshape(-1, 3), base])
    lower, upper = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
    return [[*lower[:2].tolist(), 0.0], upper.tolist()]
