"""Robot A's decisions on references as messages, and back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from lexstack_core.errors import InputError
from lexstack_core.linear import Matrix, Vector
from lexstack_core.model import Pose, Team
from lexstack_core.references import Fading, SetPoint, Setting
from lexstack_interfaces.msg import References
from lexstack_ros.conversions import (
    WORLD,
    check_robots,
    to_array,
    to_seconds,
    to_time,
    to_vector,
)

_SQUARE = 1e-6  # how far R^T R may be from the unit matrix


def references_message(setting: Setting, team: Team, sender: str) -> References:
    """Return a decision as a message."""
    message = References(revision=setting.revision, sender=sender, robots=list(team.names))
    message.header.stamp = to_time(setting.at)
    message.header.frame_id = WORLD
    goals = [np.concatenate((p.goal.position, p.goal.rotation.reshape(9))) for p in setting.ee]
    message.ee = to_array(np.concatenate(goals))
    message.base = to_array(np.concatenate([point.goal for point in setting.base]))
    message.ee_lead = to_array(np.concatenate([_lead(point, 6) for point in setting.ee]))
    message.base_lead = to_array(np.concatenate([_lead(point, 3) for point in setting.base]))
    return message


def to_setting(message: References, team: Team, where: str) -> Setting:
    """Return a decision; raises InputError. ``where``: its topic."""
    check_robots(message.robots, team, where)
    count = len(team.robots)
    ee = _rows(message.ee, count, 12, f"{where}: ee")
    base = _rows(message.base, count, 3, f"{where}: base")
    ee_lead = _fadings(_lead_rows(message.ee_lead, count, 20, f"{where}: ee_lead"))
    base_lead = _fadings(_lead_rows(message.base_lead, count, 11, f"{where}: base_lead"))
    poses = [Pose(row[:3], row[3:].reshape(3, 3)) for row in ee]
    for i, pose in enumerate(poses):
        if np.abs(pose.rotation.T @ pose.rotation - np.eye(3)).max() > _SQUARE:
            raise InputError(f"{where}: ee[{i}]: its last nine values are no rotation matrix")
    return Setting(
        to_seconds(message.header.stamp),
        message.revision,
        tuple(SetPoint(pose, fading) for pose, fading in zip(poses, ee_lead, strict=True)),
        tuple(SetPoint(row, fading) for row, fading in zip(base, base_lead, strict=True)),
    )


def _lead(point: SetPoint[Any], size: int) -> Vector:
    """Return start, duration, gap, rate and curvature of a set-point in one row."""
    fading = point.fading
    if fading is None:
        return np.zeros(2 + 3 * size)
    head = (fading.start, fading.duration)
    return np.concatenate((head, fading.gap, fading.rate, fading.curvature))


def _rows(values: Sequence[float], count: int, size: int, where: str) -> Matrix:
    """Return a checked field as rows, shape (count, size)."""
    return to_vector(values, count * size, where).reshape(count, size)


def _lead_rows(values: Sequence[float], count: int, size: int, where: str) -> Matrix:
    """Return a checked field as rows; a time may be larger than what moves."""
    rows = np.array(values, dtype=np.float64)
    if rows.shape != (count * size,):
        raise InputError(f"{where}: expected {count * size} values, got {rows.size}")
    if not np.isfinite(rows).all():
        raise InputError(f"{where}: must be finite")
    return rows.reshape(count, size)


def _fadings(rows: Matrix) -> Iterator[Fading | None]:
    """Yield what is left of the way of each set-point."""
    for row in rows:
        start, duration = float(row[0]), float(row[1])
        gap, rate, curvature = row[2:].reshape(3, -1)
        yield Fading(start, duration, gap, rate, curvature) if duration > 0.0 else None
