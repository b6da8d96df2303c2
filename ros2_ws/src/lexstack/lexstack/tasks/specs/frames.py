"""Tasks that lead a frame of a robot to a target: a pose, a position, an orientation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.references import Trajectory, Twist
from lexstack.robots import Pose
from lexstack.tasks.frame_orientation import FrameOrientationParameters
from lexstack.tasks.framed_pose import FramePoseParameters
from lexstack.tasks.framed_position import FramePositionParameters
from lexstack.tasks.specs.goals import PoseGoal, is_motion, numbers, pose_from, shape_of
from lexstack.tasks.specs.spec import Targeted, TaskSpec
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, eq=False)
class FramePose(Targeted[PoseGoal], TaskSpec, FramePoseParameters):
    """A frame goes to a pose, T(16): A J chi -> A x_dot_d + sat(gain A e).

    e is (p_d - p [m], R log3(R^T R_d) [rad]) of the measured pose. Until a target is given, a run
    holds the frame where it is, and ``solve_hqp`` asks for rest. Targets: a ``Pose``, a
    ``pinocchio.SE3``, a 4 x 4 matrix, (position, quaternion x y z w), a trajectory of poses such
    as ``timed_waypoints``, or a ``Twist``; all in the world frame.

    pink, mink and placo: ``FrameTask``. Their costs in SI units are weights against other tasks;
    here the level says what comes first, and ``mask`` what counts at all.

    Attributes:
        frame: of the robot: a link or joint of its description, or ``tool``.
        axes: of error, mask and gain: ``world``, ``local``, or another frame of the robot.
        mask: which of x, y, z, and of the turns about x, y, z, have a row.
        gain: K_p [1/s]: a number, six on the diagonal, or six rows of six.
        max_linear: what |gain e| of the position stays below [m/s].
        max_angular: what |gain e| of the orientation stays below [rad/s].
    """

    kind = "frame_pose"

    def _checked(self, target: Any) -> Any:
        return pose_goal(target, self.label)


@dataclass(frozen=True, eq=False)
class FramePosition(
    Targeted[PoseGoal | Vector | tuple[float, ...]], TaskSpec, FramePositionParameters
):
    """A frame's origin goes to a point, the first three rows of T(16); it may turn as it likes.

    Targets: a point (3,) [m] in the world, or any of ``FramePose``, whose orientation is not used.

    pink and mink: ``FrameTask`` with ``orientation_cost=0``; placo: ``PositionTask``.

    Attributes:
        frame: of the robot: a link or joint of its description, or ``tool``.
        axes: of error, mask and gain: ``world``, ``local``, or another frame of the robot.
        mask: which of x, y, z have a row.
        gain: K_p [1/s]: a number, three on the diagonal, or three rows of three.
        max_linear: what |gain e| stays below [m/s].
    """

    kind = "frame_position"

    def _checked(self, target: Any) -> Any:
        if shape_of(target) == (3,):
            return Pose(numbers(target, (3,), f"{self.label}: target"), np.eye(3))
        return pose_goal(target, self.label)


@dataclass(frozen=True, eq=False)
class FrameOrientation(Targeted[PoseGoal | Matrix], TaskSpec, FrameOrientationParameters):
    """A frame turns to an orientation, the last three rows of T(16), wherever its origin is.

    Targets: a rotation matrix (3, 3), a quaternion x y z w, or any of ``FramePose``, whose position
    is not used.

    pink and mink: ``FrameTask`` with ``position_cost=0``; placo: ``OrientationTask``.

    Attributes:
        frame: of the robot: a link or joint of its description, or ``tool``.
        axes: of error, mask and gain: ``world``, ``local``, or another frame of the robot.
        mask: which of the turns about x, y, z have a row.
        gain: K_p [1/s]: a number, three on the diagonal, or three rows of three.
        max_angular: what |gain e| stays below [rad/s].
    """

    kind = "frame_orientation"

    def _checked(self, target: Any) -> Any:
        if shape_of(target) in ((3, 3), (4,)):
            return pose_from((np.zeros(3), target), f"{self.label}: target")
        return pose_goal(target, self.label)


def pose_goal(target: Any, label: str) -> Pose | Trajectory[Pose] | Twist:
    """Return a target of a frame in the form that references have; raises InputError."""
    if isinstance(target, Twist) or is_motion(target):
        return target  # type: ignore[no-any-return]
    return pose_from(target, f"{label}: target")
