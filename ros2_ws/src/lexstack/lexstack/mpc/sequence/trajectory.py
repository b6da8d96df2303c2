"""Reference trajectories r(t) as values: straight lines between points in time, and jumps.

A base pose is x, y, yaw; an end-effector position x, y, z; an end-effector pose x, y, z and the
quaternion x, y, z, w; an orientation that quaternion alone; all in the world frame [m, rad].
Positions of joints have one number each. Between two points the position goes along a line and the
orientation turns about one fixed axis, each at a constant speed. A time that occurs twice is a
jump: nothing is interpolated across it, and from that time on the later value holds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError
from lexstack.robots.spatial import angles, between
from lexstack.types import Matrix, Vector

_ROUNDING = 1e-9  # s
_POSE, _QUATERNION = 7, 4


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Points in time; before the first and after the last one it rests.

    Attributes:
        times: shape (m,), s, not decreasing.
        values: shape (m, s). With seven columns they are end-effector poses, with four
            orientations, but not where ``joints``.
        joints: whether they are positions of joints.
    """

    times: Vector
    values: Matrix
    joints: bool = False

    def __post_init__(self) -> None:
        """Copy and freeze; raise InputError for what is not a trajectory."""
        times = np.array(self.times, dtype=np.float64)
        values = np.array(self.values, dtype=np.float64)
        if times.ndim != 1 or values.ndim != 2 or len(times) != len(values) or not len(times):
            raise InputError(
                f"trajectory: shapes {times.shape} and {values.shape}, expected (m,) and (m, s)"
            )
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise InputError("trajectory: every time and value must be finite")
        if np.any(np.diff(times) < 0.0):
            raise InputError("trajectory: times must not decrease")
        for name, array in (("times", times), ("values", values)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def goal(self) -> Vector:
        """Where it ends, shape (s,)."""
        return np.asarray(self.values[-1])

    @property
    def end(self) -> float:
        """When it has arrived there [s]."""
        return float(self.times[-1])

    def at(self, times: Vector) -> Matrix:
        """Return r at times of shape (k,) [s], shape (k, s)."""
        after = np.searchsorted(self.times, times + _ROUNDING, side="right")
        i = np.clip(after - 1, 0, len(self.times) - 1)
        j = np.clip(after, 0, len(self.times) - 1)
        length = self.times[j] - self.times[i]
        share = np.where(length > 0.0, times - self.times[i], 0.0)
        share = np.clip(share / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        found = self.values[i] + share[:, None] * (self.values[j] - self.values[i])
        if not self.joints and found.shape[1] in (_POSE, _QUATERNION):
            turned = slice(found.shape[1] - _QUATERNION, None)
            found[:, turned] = between(self.values[i, turned], self.values[j, turned], share)
        return np.asarray(found)


def hold(value: Vector, *, joints: bool = False) -> Trajectory:
    """Return a reference that never moves: a waypoint; ``joints``: of joints."""
    return Trajectory(np.zeros(1), np.atleast_2d(value), joints)


def steps(times: Vector, values: Matrix) -> Trajectory:
    """Return a reference that jumps to ``values[i]`` at ``times[i]``: a square wave, for one."""
    moments, points = np.atleast_1d(times), np.atleast_2d(values)
    return Trajectory(
        np.concatenate((moments[:1], np.repeat(moments[1:], 2))),
        np.concatenate((np.repeat(points[:-1], 2, axis=0), points[-1:])),
    )


def ee_path(begin: float, points: Matrix, speed: float, turn: float = np.inf) -> Trajectory:
    """Return straight lines through end-effector positions (m, 3) or poses (m, 7).

    Args:
        begin: when it leaves the first point [s].
        points: at least one.
        speed: along the lines [m/s], positive.
        turn: of the orientation, at most this [rad/s], positive.

    Raises:
        InputError: a speed that is not positive, or points of another shape.
    """
    values = _points(points, (3, _POSE))
    turns = _turns(values[:, 3:])
    return _timed(begin, values, 3, turns, (speed, turn))


def drive_path(begin: float, pose: Vector, points: Matrix, speed: float, turn: float) -> Trajectory:
    """Return the way of a differential base: it turns, drives along a line, and so on.

    It drives backwards to a point that is behind it. At the end of poses it turns to their yaw.

    Args:
        begin: when it leaves [s].
        pose: where it is: x, y, yaw.
        points: that it goes through, poses (m, 3) or positions (m, 2).
        speed: along the lines [m/s], positive.
        turn: rad/s, positive.
    """
    values = _points(points, (2, 3))
    ways = [np.array(pose, dtype=np.float64)]
    for point in values:
        x, y, yaw = ways[-1]
        gap = point[:2] - ways[-1][:2]
        if np.linalg.norm(gap) > _ROUNDING:
            heading = _nearest(np.arctan2(gap[1], gap[0]), yaw, np.pi)
            ways += [np.array([x, y, heading]), np.array([*point[:2], heading])]
        if len(point) > 2:
            ways.append(np.array([*point[:2], _nearest(point[2], ways[-1][2], 2.0 * np.pi)]))
    every = np.array(ways)
    turns = np.abs(np.diff(every[:, 2]))
    return _timed(begin, every[:, : values.shape[1]], 2, turns, (speed, turn))


def _nearest(angle: float, to: float, period: float) -> float:
    """Return the angle that differs by whole periods and is nearest to another one [rad]."""
    return float(angle + period * np.round((to - angle) / period))


def orientation_path(begin: float, points: Matrix, turn: float) -> Trajectory:
    """Return turns about fixed axes through quaternions x, y, z, w, shape (m, 4).

    ``turn`` [rad/s] is positive; the rest is as in ``ee_path``.
    """
    values = _points(points, (_QUATERNION,))
    return _timed(begin, values, 0, _turns(values), (np.inf, turn))


def joint_path(
    begin: float, points: Matrix, slides: NDArray[np.bool_], speed: float, turn: float
) -> Trajectory:
    """Return straight lines through joint positions (m, s), of which those that ``slides`` are m.

    All joints arrive together; no one exceeds ``speed`` [m/s] or ``turn`` [rad/s].
    """
    values = np.array(points, dtype=np.float64)
    steps_of = np.abs(np.diff(values, axis=0)) / np.where(slides, speed, turn)
    times = begin + np.concatenate(([0.0], np.cumsum(steps_of.max(axis=1))))
    return Trajectory(times, values, joints=True)


def _turns(quaternions: Matrix) -> Vector:
    """Return the angle between each two rotations in a row, shape (m - 1,); changes the signs.

    Without columns all angles are zero.
    """
    if quaternions.shape[1]:
        quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
        for i in range(1, len(quaternions)):  # q and -q are one rotation: take the near one
            if quaternions[i] @ quaternions[i - 1] < 0.0:
                quaternions[i] *= -1.0
    return np.asarray(2.0 * angles(quaternions[:-1], quaternions[1:]))


def base_path(begin: float, points: Matrix, speed: float, turn: float = np.inf) -> Trajectory:
    """Return straight lines through base poses x, y, yaw (m, 3), or positions (m, 2).

    Yaw turns the short way round. Arguments and errors are those of ``ee_path``.
    """
    values = _points(points, (2, 3))
    turns = np.diff(values[:, 2:], axis=0)
    turns = np.arctan2(np.sin(turns), np.cos(turns))
    values[1:, 2:] = values[:1, 2:] + np.cumsum(turns, axis=0)
    return _timed(begin, values, 2, np.abs(turns).sum(axis=1), (speed, turn))


def _points(points: Matrix, columns: tuple[int, ...]) -> Matrix:
    """Return a copy of points; raises InputError for another shape."""
    values = np.array(points, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] not in columns:
        raise InputError(f"path: points of shape {values.shape}, expected columns: {columns}")
    return values


def _timed(
    begin: float, values: Matrix, lengths: int, turns: Vector, speeds: tuple[float, float]
) -> Trajectory:
    """Return the trajectory on which neither speed is exceeded; the first columns are lengths."""
    if not min(speeds) > 0.0:
        raise InputError(f"path: speed and turn must be > 0, got {speeds[0]} and {speeds[1]}")
    distances = np.linalg.norm(np.diff(values[:, :lengths], axis=0), axis=1)
    durations = np.maximum(distances / speeds[0], turns / speeds[1])
    return Trajectory(begin + np.concatenate(([0.0], np.cumsum(durations))), values)
