"""A decision as plain vectors, as messages and bags carry it; see ``References.msg``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, TypeVar

import numpy as np

from lexstack.errors import InputError
from lexstack.references.fading import Fading
from lexstack.references.set_point import SetPoint
from lexstack.references.timeline import Setting
from lexstack.references.trajectory import Trajectory
from lexstack.robots import Pose
from lexstack.types import Matrix, Vector

T = TypeVar("T")

WIDTHS = {"ee": 12, "base": 3, "ee_lead": 20, "base_lead": 11}
"""How many numbers each vector has per robot."""

_HUGE = 1e6  # m, rad: no reference is there
_SQUARE = 1e-6  # how far R^T R may be from the unit matrix


def encode(setting: Setting) -> dict[str, Vector]:
    """Return the vectors of a decision, by the names in ``WIDTHS``.

    Raises:
        InputError: a reference is no set-point: messages have no fields for others.
    """
    tools, bases = _set_points(setting.ee), _set_points(setting.base)
    if setting.frames or setting.postures:
        raise InputError("references: frames and postures are not sent, only tools and bases")
    poses = [np.concatenate((p.goal.position, p.goal.rotation.reshape(9))) for p in tools]
    return {
        "ee": np.concatenate(poses),
        "base": np.concatenate([point.goal for point in bases]),
        "ee_lead": np.concatenate([_lead(point, 6) for point in tools]),
        "base_lead": np.concatenate([_lead(point, 3) for point in bases]),
    }


def decode(
    at: float, revision: int, vectors: Mapping[str, Any], robots: int, where: str
) -> Setting:
    """Return the decision that vectors describe, equal in every bit to the one encoded.

    Args:
        at: simulated time of its first tick [s].
        revision: its number.
        vectors: by the names in ``WIDTHS``.
        robots: how many robots there are.
        where: the topic, for errors.

    Raises:
        InputError: a vector of another length, a number that is not finite or out of range, or
            no rotation.
    """
    rows = {
        name: _rows(vectors[name], robots, width, f"{where}: {name}")
        for name, width in WIDTHS.items()
    }
    poses = [Pose(row[:3], row[3:].reshape(3, 3)) for row in rows["ee"]]
    for i, pose in enumerate(poses):
        if np.abs(pose.rotation.T @ pose.rotation - np.eye(3)).max() > _SQUARE:
            raise InputError(f"{where}: ee[{i}]: its last nine values are no rotation matrix")
    ee, base = _fadings(rows["ee_lead"]), _fadings(rows["base_lead"])
    return Setting(
        at,
        revision,
        tuple(SetPoint(pose, fading) for pose, fading in zip(poses, ee, strict=True)),
        tuple(SetPoint(row, fading) for row, fading in zip(rows["base"], base, strict=True)),
    )


def _set_points(points: Iterable[Trajectory[T]]) -> tuple[SetPoint[T], ...]:
    """Return references as the set-points that they are."""
    found = []
    for point in points:
        if not isinstance(point, SetPoint) or point.fed:
            raise InputError(f"references: a {type(point).__name__} is not sent, only set-points")
        found.append(point)
    return tuple(found)


def _lead(point: SetPoint[Any], size: int) -> Vector:
    """Return start, duration, gap, rate and curvature of a set-point in one row."""
    fading = point.fading
    if fading is None:
        return np.zeros(2 + 3 * size)
    head = (fading.start, fading.duration)
    return np.concatenate((head, fading.gap, fading.rate, fading.curvature))


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
        start, duration = float(row[0]), float(row[1])
        gap, rate, curvature = row[2:].reshape(3, -1)
        yield Fading(start, duration, gap, rate, curvature) if duration > 0.0 else None
