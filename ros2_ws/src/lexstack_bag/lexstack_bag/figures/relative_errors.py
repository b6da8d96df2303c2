"""What robots have to do with each other and with what stands in their way, phase by phase."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack.tasks import other_end, pose_error
from lexstack.types import Matrix, Vector
from lexstack_bag.figures.phases import held_objects
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.run.run import Run

_MM = 1e3
_MRAD = 1e3

Ticks = NDArray[np.bool_]
PerRobot = dict[str, float | None]

TITLES = {
    "relative_error_mm": "object [mm]",
    "relative_peak_error_mm": "object, peak [mm]",
    "relative_peak_error_mrad": "object, peak [mrad]",
    "obstacle_distance_mm": "nearest obstacle [mm; below 0: a sphere overlaps it]",
    "posture_error_mrad": "posture [mrad]",
}
"""What tables show of a phase besides errors of tools and bases, and under which title.

Distances are those of the spheres that stand for a robot, which stick out beyond its shape.
"""


@dataclass(frozen=True, slots=True)
class RelativeErrors:
    """The figures of one phase, by robot; None where its stack or the scenario has no such thing.

    An object's errors stand under the robot whose task ``relative_pose`` holds it.

    Attributes:
        relative_error_mm: steady state, distance of the other tool from where it belongs.
        relative_error_mrad: steady state, its angle.
        relative_peak_error_mm: largest in the phase, the blend included.
        relative_peak_error_mrad: the same for the angle.
        obstacle_distance_mm: least distance of the robot's spheres to an obstacle's surface;
            negative: inside.
    """

    relative_error_mm: PerRobot | None
    relative_error_mrad: PerRobot | None
    relative_peak_error_mm: PerRobot | None
    relative_peak_error_mrad: PerRobot | None
    obstacle_distance_mm: PerRobot | None


def relative_errors_of(
    run: Run, team: Team, time_series: TimeSeries, stack: str, ticks: Ticks, steady: Ticks
) -> RelativeErrors:
    """Return the figures of a phase.

    Args:
        run: the run.
        team: its robots.
        time_series: its time series.
        stack: the phase's.
        ticks: which are in the phase, shape (T,).
        steady: which of them make its steady state, shape (T,).
    """
    tasks = held_objects(run, stack)
    held = [_relative_errors(run, team, time_series, pair, ticks) for pair in tasks.items()]
    linear, angular = ([errors[k] for errors in held] for k in (0, 1))
    ends = steady[ticks]

    def each(errors: list[Vector], steadily: bool) -> PerRobot | None:
        if not tasks or not ticks.any():
            return None
        values = [
            float(np.mean(e[ends]) if steadily else np.max(e)) if ends.any() else None
            for e in errors
        ]
        return {name: dict(zip(tasks, values, strict=True)).get(name) for name in run.robots}

    return RelativeErrors(
        each(linear, steadily=True),
        each(angular, steadily=True),
        each(linear, steadily=False),
        each(angular, steadily=False),
        _least_distances(run, team, ticks),
    )


def obstacle_distances(team: Team, q: Vector, stamp: float) -> Matrix:
    """Return how far each robot's spheres are from each obstacle, shape (robots, k), m.

    Args:
        team: the robots and the obstacles.
        q: configuration of all robots, shape (n,).
        stamp: simulated time [s].
    """
    spheres, obstacles = team.spheres(q), team.obstacles
    lines = spheres.centers[:, None] - obstacles.at(stamp)
    distances = np.linalg.norm(lines, axis=2) - spheres.radii[:, None] - obstacles.radii
    return np.array(
        [
            distances[spheres.owners == robot].min(axis=0, initial=np.inf)
            for robot in range(len(team.robots))
        ]
    )


def _relative_errors(
    run: Run, team: Team, time_series: TimeSeries, names: tuple[str, str], ticks: Ticks
) -> tuple[Vector, Vector]:
    """Return |e_p| [mm] and |e_R| [mrad] of an object at each tick of a phase."""
    one, other = (team.index(name) for name in names)
    errors = []
    for row in np.flatnonzero(ticks):
        tools, references = team.tools(run.plant.q[row]), time_series.references[row]
        goal = other_end(tools[one], references.ee[one], references.ee[other])
        errors.append(pose_error(tools[other], goal))
    array = np.array(errors).reshape(-1, 6)
    linear, angular = (np.linalg.norm(part, axis=1) for part in (array[:, :3], array[:, 3:]))
    return _MM * linear, _MRAD * angular


def _least_distances(run: Run, team: Team, ticks: Ticks) -> PerRobot | None:
    """Return the least distance of each robot to any obstacle in a phase [mm]."""
    rows = np.flatnonzero(ticks)
    if not len(team.obstacles) or not rows.size:
        return None
    least = np.min(
        [obstacle_distances(team, run.plant.q[row], float(run.plant.stamp[row])) for row in rows],
        axis=(0, 2),
    )
    return {
        name: float(_MM * value) if np.isfinite(value) else None
        for name, value in zip(run.robots, least, strict=True)
    }
