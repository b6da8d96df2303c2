"""A decision as plain vectors, as messages and bags carry it; see ``References.msg``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from lexstack.errors import InputError
from lexstack.references.fading import Fading
from lexstack.references.moving import (
    BASE,
    EE,
    POSTURE,
    Moving,
    fading_of,
    lead_of,
    moving_of,
    pose_of,
    trajectory_of,
)
from lexstack.references.set_point import SetPoint
from lexstack.references.timeline import Setting
from lexstack.references.trajectory import Trajectory
from lexstack.references.values import TOOL
from lexstack.types import Matrix, Vector

T = TypeVar("T")

WIDTHS = {"ee": 12, "base": 3, "ee_lead": 20, "base_lead": 11}
"""How many numbers each vector has per robot."""

_HUGE = 1e6  # m, rad: no reference is there


def encode(setting: Setting) -> dict[str, Vector]:
    """Return the vectors of a decision, by the names in ``WIDTHS``.

    Of a tool or base that is in ``encode_moving`` they have where it ends.
    """
    tools = [_set_point(point) for point in setting.ee]
    bases = [_set_point(point) for point in setting.base]
    poses = [np.concatenate((p.goal.position, p.goal.rotation.reshape(9))) for p in tools]
    return {
        "ee": np.concatenate(poses),
        "base": np.concatenate([point.goal for point in bases]),
        "ee_lead": np.concatenate([_lead(point, 6) for point in tools]),
        "base_lead": np.concatenate([_lead(point, 3) for point in bases]),
    }


def encode_moving(setting: Setting) -> Iterator[Moving]:
    """Yield what the vectors have no room for: trajectories, further frames, and postures.

    Raises:
        InputError: a trajectory is of a user's own kind.
    """
    for of, points in ((EE, setting.ee), (BASE, setting.base)):
        for robot, point in enumerate(points):
            if not isinstance(point, SetPoint) or point.fed:
                yield moving_of(point, robot, of)
    for (robot, frame), pose in setting.frames.items():
        yield moving_of(pose, robot, EE, frame)
    for robot, posture in setting.postures.items():
        yield moving_of(posture, robot, POSTURE)


def decode(
    at: float,
    revision: int,
    vectors: Mapping[str, Any],
    robots: int,
    where: str,
    *,
    moving: Sequence[Moving] = (),
    arms: Sequence[int] = (),
) -> Setting:
    """Return the decision that vectors describe, equal in every bit to the one encoded.

    Args:
        at: simulated time of its first tick [s].
        revision: its number.
        vectors: by the names in ``WIDTHS``.
        robots: how many robots there are.
        where: the topic, for errors.
        moving: what ``encode_moving`` found.
        arms: how many joints each robot's arm has, where there are postures.

    Raises:
        InputError: a vector of another length, a number that is not finite or out of range, or
            no rotation.
    """
    rows = {
        name: _rows(vectors[name], robots, width, f"{where}: {name}")
        for name, width in WIDTHS.items()
    }
    poses = []
    for i, row in enumerate(rows["ee"]):
        try:
            poses.append(pose_of(row))
        except InputError as error:
            raise InputError(f"{where}: ee[{i}]: {error}") from error
    ee, base = _fadings(rows["ee_lead"]), _fadings(rows["base_lead"])
    setting = Setting(
        at,
        revision,
        tuple(SetPoint(pose, fading) for pose, fading in zip(poses, ee, strict=True)),
        tuple(SetPoint(row, fading) for row, fading in zip(rows["base"], base, strict=True)),
    )
    for k, entry in enumerate(moving):
        place = f"{where}: trajectories[{k}]"
        if not 0 <= entry.robot < robots:
            raise InputError(f"{place}: no such robot")
        size = arms[entry.robot] if entry.of == POSTURE else WIDTHS["base"]
        setting = _with(setting, entry, trajectory_of(entry, size, place), place)
    return setting


def _with(setting: Setting, entry: Moving, point: Trajectory[Any], where: str) -> Setting:
    """Return a decision with one more of its references put in."""
    i = entry.robot
    if entry.of == EE and entry.frame != TOOL:
        return replace(setting, frames={**setting.frames, (i, entry.frame): point})
    if entry.of == EE:
        return replace(setting, ee=(*setting.ee[:i], point, *setting.ee[i + 1 :]))
    if entry.of == BASE:
        return replace(setting, base=(*setting.base[:i], point, *setting.base[i + 1 :]))
    if entry.of == POSTURE:
        return replace(setting, postures={**setting.postures, i: point})
    raise InputError(f"{where}: it is of neither a frame, a base nor a posture")


def _set_point(point: Trajectory[T]) -> SetPoint[T]:
    """Return a set-point; of another reference where it ends."""
    if isinstance(point, SetPoint):
        return point
    return SetPoint(point.at(point.end))


def _lead(point: SetPoint[Any], size: int) -> Vector:
    """Return start, duration, gap, rate and curvature of a set-point in one row."""
    return np.zeros(2 + 3 * size) if point.fading is None else lead_of(point.fading)


def _rows(values: Any, robots: int, width: int, where: str) -> Matrix:
    """Return a checked vector as rows, shape (robots, width), read-only."""
    rows = np.array(values, dtype=np.float64)
    if rows.shape != (robots * width,):
        raise InputError(f"{where}: expected {robots * width} values, got {rows.size}")
    if not np.isfinite(rows).all():
        raise InputError(f"{where}: every value must be finite")
    if width in (WIDTHS["ee"], WIDTHS["base"]) and np.abs(rows).max() > _HUGE:
        raise InputError(f"{where}: out of range: at most {_HUGE:g}")
    rows.setflags(write=False)
    return rows.reshape(robots, width)


def _fadings(rows: Matrix) -> Iterator[Fading | None]:
    """Yield what is left of the way of each set-point."""
    for row in rows:
        yield fading_of(row) if row[1] > 0.0 else None
