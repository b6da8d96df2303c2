"""One task of a sequence: where it leads, how it is planned, and when it is done."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc.measures import COLUMNS, Kind, measure_of
from lexstack.mpc.sequence.robot_pose import RobotPose
from lexstack.mpc.sequence.trajectory import (
    Trajectory,
    base_path,
    drive_path,
    ee_path,
    hold,
    joint_path,
    orientation_path,
)
from lexstack.options import shown
from lexstack.robots import RobotModel
from lexstack.robots.assembly import TOOL

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
        turn: angular speed at most, where there is a speed [rad/s]; None: no limit. Orientations
            have this speed alone, and of joints it is that of those that turn.
        tolerance: the task is done when its error is smaller [m] ...
        tolerance_angle: ... and so is that of its angles [rad] ...
        dwell: ... for so long [s], after its trajectory has ended.
        held: it is not done before it is released, however long it takes.
        frame: which one an end-effector kind moves, as ``RobotModel.frame`` knows it.
        joints: of ``joint_positions``; empty: all but the base's.
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
    frame: str = TOOL
    joints: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Raise InputError for what cannot be a task."""
        where = f"task {self.name!r}"
        if self.kind not in COLUMNS:
            raise InputError(f"{where}: kind: {self.kind!r} is not one of {', '.join(COLUMNS)}")
        _check_names(self, where)
        if not self.points:
            raise InputError(f"{where}: points: at least one is needed")
        for i, point in enumerate(self.points):
            columns = COLUMNS[self.kind] or len(self.joints or self.points[0])
            _check_point(self.kind, columns, point, f"{where}: points[{i}]")
        rates = {"speed": self.speed, "turn": self.turn}
        for name, value in rates.items():
            if value is not None and not 0.0 < value < np.inf:
                raise InputError(f"{where}: {name}: must be finite and > 0, got {value}")
        for name in ("tolerance", "tolerance_angle"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{where}: {name}: must be > 0, got {getattr(self, name)}")
        if not 0.0 <= self.dwell < np.inf:
            raise InputError(f"{where}: dwell: must be finite and >= 0, got {self.dwell}")

    @property
    def numbers(self) -> int:
        """How many coordinates each of its points has."""
        return len(self.points[0])

    def check(self, robot: RobotModel) -> None:
        """Raise InputError where a robot has no such frame, joint or base, or more joints."""
        columns = measure_of(self, robot).columns
        if self.numbers != columns:
            raise InputError(
                f"task {self.name!r}: points[0]: expected {columns} numbers, one per joint, "
                f"got {self.numbers}"
            )

    def planned(self, pose: RobotPose) -> Trajectory:
        """Return its trajectory from the present pose."""
        joints = self.kind == "joint_positions"
        speed, turn = self.speed or np.inf, self.turn or np.inf
        paced = {"ee_orientation": self.turn, "joint_positions": self.speed or self.turn}
        if paced.get(self.kind, self.speed) is None:
            return hold(np.array(self.points[-1]), joints=joints)
        through = np.array([pose.value(self), *self.points])
        if joints:
            return joint_path(pose.stamp, through, pose.slides(self), speed, turn)
        if self.kind == "ee_orientation":
            return orientation_path(pose.stamp, through, turn)
        robot = pose.robot
        if robot is not None and robot.differential and self.kind.startswith("base"):
            turn = min(turn, 0.5 * float(robot.limits.velocity[1]))
            return drive_path(pose.stamp, pose.base, np.array(self.points), speed, turn)
        path = base_path if self.kind.startswith("base") else ee_path
        return path(pose.stamp, through, speed, turn)


def _check_names(task: SequenceTask, where: str) -> None:
    """Raise InputError for a frame or joints where the kind has none."""
    if task.frame != TOOL and not task.kind.startswith("ee"):
        raise InputError(f"{where}: frame: {task.kind} moves no frame, got {shown(task.frame)}")
    if task.joints and task.kind != "joint_positions":
        raise InputError(f"{where}: joints: only for joint_positions, not for {task.kind}")


def _check_point(kind: Kind, columns: int, point: Point, where: str) -> None:
    """Raise InputError for a point of the wrong length, not finite, or without an orientation."""
    if len(point) != columns or not columns or not np.isfinite(point).all():
        raise InputError(f"{where}: expected {columns} finite numbers, got {point}")
    turned = kind in ("ee_pose", "ee_orientation")
    if turned and not np.linalg.norm(point[-4:]) > 1e-6:
        raise InputError(f"{where}: its quaternion is zero")
