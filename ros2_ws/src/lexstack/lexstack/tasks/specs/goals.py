"""The forms in which a program may give a goal, and the values that they stand for."""

from __future__ import annotations

from typing import Any, TypeAlias, cast

import numpy as np
import pinocchio as pin

from lexstack.errors import InputError
from lexstack.references import Trajectory, Twist
from lexstack.robots import Pose
from lexstack.robots.spatial import from_quaternion
from lexstack.types import Matrix, Vector

_UNIT = 1e-6  # how far a rotation may be from orthonormal, a quaternion from length 1

PoseLike: TypeAlias = Pose | pin.SE3 | Matrix | tuple[Any, Any]
"""A ``Pose``, a ``pinocchio.SE3``, a homogeneous matrix (4, 4), or a position (3,) [m] with a
quaternion x, y, z, w or a rotation matrix (3, 3)."""
PoseGoal: TypeAlias = PoseLike | Trajectory[Pose] | Twist
"""A pose, a trajectory of poses, or a twist that is asked for until the next one comes."""
VectorGoal: TypeAlias = Vector | tuple[float, ...] | list[float] | Trajectory[Vector]
"""Numbers, or a trajectory of them."""


def numbers(value: object, shape: tuple[int, ...], where: str) -> Vector:
    """Return finite numbers as an array of a shape; raises InputError for anything else."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full((), np.nan)
    if array.shape != shape or not np.isfinite(array).all():
        size = " x ".join(map(str, shape)) or "one"
        raise InputError(f"{where}: expected {size} finite numbers, got {_brief(value)}")
    return array


def shape_of(value: object) -> tuple[int, ...]:
    """Return the shape of numbers; of anything else an empty one."""
    try:
        return np.shape(cast("Any", value))
    except ValueError:  # lists of different lengths
        return ()


def pose_from(value: PoseLike, where: str) -> Pose:
    """Return a pose from any of its forms; raises InputError."""
    if isinstance(value, Pose):
        return Pose(
            numbers(value.position, (3,), f"{where}: position"), _rotation(value.rotation, where)
        )
    if isinstance(value, pin.SE3):
        return Pose(value.translation.copy(), value.rotation.copy())
    if isinstance(value, tuple) and len(value) == 2:
        return Pose(numbers(value[0], (3,), f"{where}: position"), _rotation(value[1], where))
    if shape_of(value) == (4, 4):
        matrix = numbers(value, (4, 4), where)
        return Pose(matrix[:3, 3].copy(), _rotation(matrix[:3, :3], where))
    raise InputError(
        f"{where}: expected a Pose, pinocchio.SE3, 4 x 4 matrix or (position, quaternion), "
        f"got {_brief(value)}"
    )


def _rotation(value: object, where: str) -> Matrix:
    """Return a rotation matrix from a matrix or a quaternion x, y, z, w."""
    if shape_of(value) == (4,):
        quaternion = numbers(value, (4,), f"{where}: quaternion")
        if abs(float(np.linalg.norm(quaternion)) - 1.0) > _UNIT:
            raise InputError(f"{where}: quaternion: its length must be 1, got {_brief(value)}")
        return from_quaternion(quaternion)
    matrix = numbers(value, (3, 3), f"{where}: rotation")
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > _UNIT or np.linalg.det(matrix) < 0.0:
        raise InputError(f"{where}: rotation: it is not orthonormal, or it mirrors")
    return matrix


def is_motion(value: object) -> bool:
    """Return whether a goal moves by itself: a trajectory."""
    return all(hasattr(value, name) for name in ("at", "rate", "end"))


def _brief(value: object) -> str:
    """Return a value, or its shape, as it may stand in an error."""
    if isinstance(value, np.ndarray) and value.size > 4:
        return f"an array of shape {value.shape}"
    return " ".join(str(value)[:60].split())
