"""One task of a sequence: where it leads, how it is planned, and when it is done."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc.sequence.robot_pose import RobotPose
from lexstack.mpc.sequence.trajectory import Trajectory, base_path, ee_path, hold
from lexstack.mpc.tracking_objectives import MEASURES, Kind

Point = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SequenceTask:
    """One task of a sequence, and when it is done.

    Attributes:
        name: unique in its sequence.
        kind: see ``Objective``.
        points: where it leads through, the last one is the goal; coordinates as in ``Objective``.
        speed: along straight lines from the present pose through the points [m/s]; None: the goal
            alone is the reference, at once (a waypoint).
        turn: angular speed at most, where there is a speed [rad/s]; None: no limit.
        tolerance: the task is done when its error is smaller [m] ...
        tolerance_angle: ... and so is that of its angles [rad] ...
        dwell: ... for so long [s], after its trajectory has ended.
        held: it is not done before it is released, however long it takes.
    """

    name: str
    kind: Kind
    points: tuple[Point, ...]
    speed: float | None = None
    turn: float | None = None
    tolerance: float = 0.02
    tolerance_angle: float = 0.1
    dwell: float = 0.0
    held: bool = False

    def __post_init__(self) -> None:
        """Raise InputError for what cannot be a task."""
        where = f"task {self.name!r}"
        if self.kind not in MEASURES:
            raise InputError(f"{where}: kind: {self.kind!r} is not one of {', '.join(MEASURES)}")
        if not self.points:
            raise InputError(f"{where}: points: at least one is needed")
        for i, point in enumerate(self.points):
            _check_point(self.kind, point, f"{where}: points[{i}]")
        rates = {"speed": self.speed, "turn": self.turn}
        for name, value in rates.items():
            if value is not None and not 0.0 < value < np.inf:
                raise InputError(f"{where}: {name}: must be finite and > 0, got {value}")
        for name in ("tolerance", "tolerance_angle"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{where}: {name}: must be > 0, got {getattr(self, name)}")
        if not 0.0 <= self.dwell < np.inf:
            raise InputError(f"{where}: dwell: must be finite and >= 0, got {self.dwell}")

    def planned(self, pose: RobotPose) -> Trajectory:
        """Return its trajectory from the present pose."""
        if self.speed is None:
            return hold(np.array(self.points[-1]))
        through = np.array([pose.value(self.kind), *self.points])
        path = base_path if self.kind.startswith("base") else ee_path
        return path(pose.stamp, through, self.speed, np.inf if self.turn is None else self.turn)


def _check_point(kind: Kind, point: Point, where: str) -> None:
    """Raise InputError for a point of the wrong length, not finite, or without an orientation."""
    expected = MEASURES[kind].columns
    if len(point) != expected or not np.isfinite(point).all():
        raise InputError(f"{where}: expected {expected} finite numbers, got {point}")
    if kind == "ee_pose" and not np.linalg.norm(point[3:]) > 1e-6:
        raise InputError(f"{where}: its quaternion is zero")
