"""A run as tables for pandas, PlotJuggler and spreadsheets: CSV with a header, or Parquet.

A column is named after what it holds, its robot and joint, and its unit in brackets, as in
``q/robot_a/base_x [m]``. Numbers are written in full: reading them gives the same bits.
"""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack.types import Matrix
from lexstack_bag.errors import BagError
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.run.partial_chi import joined
from lexstack_bag.run.run import POSITIONS, Run
from lexstack_bag.storage.container import Progress
from lexstack_bag.storage.folders import writing

_ROWS = 10_000  # written at a time
_TIME = "time [s]"
_AXES = ("x [m]", "y [m]", "z [m]")
_NAMES = {"stamp": _TIME}
_UNITS = {
    "duration": "s", "error": "m", "error_angle": "rad", "gap": "m/s, rad/s", "solve_time": "s",
}  # fmt: skip
_RAGGED = {"errors": "error/level_{level} [m]", "slacks": "slack/level_{level}"}
_LEFT_OUT = ("references", "robots", "sent")
_BASE = ("x [m]", "y [m]", "yaw [rad]")

Columns = Mapping[str, NDArray[Any]]
"""Columns of equal length by their names."""


@dataclass(frozen=True, slots=True)
class _Kind:
    """What a vector over the joints is: the units of its entries, and whether it is as q or chi."""

    linear: str
    angular: str
    of_q: bool


_POSITION, _VELOCITY = _Kind("m", "rad", of_q=True), _Kind("m/s", "rad/s", of_q=False)


def tables(run: Run, time_series: TimeSeries) -> dict[str, Columns]:
    """Return the tables of a run by name: plant, errors, each chi and plan, transition, targets."""
    team = run.team()
    found: dict[str, Columns] = {
        "plant": _stream(run.plant, team),
        "errors": _errors(run, time_series),
    }
    for node, chi in run.chi.items():
        if len(chi.tick):
            found[f"{node}_chi"] = _stream(joined(run, node), team)
    for robot, plan_topics in run.plan_topics.items():
        found[f"{robot}_plans"] = _stream(plan_topics.progress, team)
    found["transition"] = _stream(run.transition, team)
    found["targets"] = _targets(run)
    return found


def write_csv(folder: Path, run: Run, time_series: TimeSeries, progress: Progress) -> list[Path]:
    """Write every table as ``NAME.csv`` and return the files; raises BagError."""
    return _write(folder, ".csv", _csv, tables(run, time_series), progress)


def write_parquet(
    folder: Path, run: Run, time_series: TimeSeries, progress: Progress
) -> list[Path]:
    """Write every table as ``NAME.parquet`` and return the files; raises BagError."""
    try:
        import pyarrow.parquet  # noqa: F401, PLC0415  # large, and needed here alone
    except ImportError as error:
        raise BagError("--parquet: pyarrow is not installed: pip install pyarrow") from error
    return _write(folder, ".parquet", _parquet, tables(run, time_series), progress)


def _write(
    folder: Path,
    suffix: str,
    write: Callable[[Path, Columns], None],
    content: Mapping[str, Columns],
    progress: Progress,
) -> list[Path]:
    """Write tables to files of their names."""
    paths = [folder / f"{name}{suffix}" for name in content]
    with writing(folder, make=True):
        for done, (path, columns) in enumerate(zip(paths, content.values(), strict=True)):
            progress(done / len(paths))
            write(path, columns)
    progress(1.0)
    return paths


def _csv(path: Path, columns: Columns) -> None:
    """Write one table as CSV."""
    length = len(next(iter(columns.values())))
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        for first in range(0, length, _ROWS):
            part = (column[first : first + _ROWS].tolist() for column in columns.values())
            writer.writerows(zip(*part, strict=True))


def _parquet(path: Path, columns: Columns) -> None:
    """Write one table as Parquet."""
    import pyarrow as pa  # noqa: PLC0415
    from pyarrow import parquet  # noqa: PLC0415

    parquet.write_table(pa.table(dict(columns)), path, compression="zstd")


def _stream(stream: Any, team: Team) -> Columns:
    """Return the messages of a topic: a column for each number of each of their fields."""
    columns: dict[str, NDArray[Any]] = {}
    for field in dataclasses.fields(stream):
        name, values = field.name, getattr(stream, field.name)
        if name in _RAGGED:
            columns |= {
                _RAGGED[name].format(level=k + 1): column
                for k, column in enumerate(np.asarray(values).T)
            }
        elif field.type in ("Matrix", "Single"):
            kind = _POSITION if name in POSITIONS else _VELOCITY
            columns |= _joints(name, values, team, kind)
        elif name not in _LEFT_OUT:
            unit = _UNITS.get(name)
            columns[f"{name} [{unit}]" if unit else _NAMES.get(name, name)] = values
    return columns


def _errors(run: Run, time_series: TimeSeries) -> Columns:
    """Return positions, targets and errors at every tick of the plant."""
    columns: dict[str, NDArray[Any]] = {"tick": run.plant.tick, _TIME: time_series.time}
    for i, robot in enumerate(run.robots):
        for name, values, axes in (
            ("ee", time_series.ee, _AXES),
            ("ee_target", time_series.ee_target, _AXES),
            ("base", time_series.base, _BASE),
            ("base_target", time_series.base_target, _BASE),
        ):
            columns |= {f"{name}/{robot}/{axis}": values[:, i, k] for k, axis in enumerate(axes)}
        columns[f"ee_error/{robot} [mm]"] = time_series.ee_error[:, i]
        columns[f"base_error/{robot} [mm]"] = time_series.base_error[:, i]
        columns[f"yaw_error/{robot} [mrad]"] = time_series.yaw_error[:, i]
    return columns


def _targets(run: Run) -> Columns:
    """Return the references that users sent."""
    targets = run.targets
    position = np.array([target.position for target in targets]).reshape(-1, 3)
    turn = np.array([target.quaternion for target in targets]).reshape(-1, 4)
    return {
        _TIME: np.array([target.time for target in targets], dtype=np.float64),
        "robot": np.array([target.robot for target in targets], dtype=object),
        "kind": np.array([target.kind for target in targets], dtype=object),
        **{f"position/{axis}": position[:, k] for k, axis in enumerate(_AXES)},
        **{f"quaternion/{axis}": turn[:, k] for k, axis in enumerate("xyzw")},
    }


def _joints(name: str, values: Matrix, team: Team, kind: _Kind) -> dict[str, NDArray[Any]]:
    """Return one column per joint."""
    return {
        f"{name}/{robot}/{joint} [{unit}]": values[:, column]
        for column, (robot, joint, unit) in enumerate(_entries(team, kind))
    }


def _entries(team: Team, kind: _Kind) -> Sequence[tuple[str, str, str]]:
    """Return robot, joint and unit of every entry of a vector over the joints."""
    return [
        (robot.name, joint, kind.linear if slides else kind.angular)
        for robot in team.robots
        for joint, slides in (
            zip(robot.coordinates, robot.sliding, strict=True)
            if kind.of_q
            else zip(robot.joints, robot.prismatic, strict=True)
        )
    ]
