"""The tasks, one file each, and stacks of them."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.tasks.axis_alignment import AxisAlignment
    from lexstack.tasks.base_pose import Base
    from lexstack.tasks.centre_of_mass import CentreOfMass
    from lexstack.tasks.collision_avoidance import CollisionAvoidance, CollisionAvoidanceParameters
    from lexstack.tasks.cone import Cone
    from lexstack.tasks.frame_orientation import FrameOrientation
    from lexstack.tasks.frame_pose import EePose, EePoseParameters, pose_error, saturated
    from lexstack.tasks.frame_position import EePosition
    from lexstack.tasks.frame_velocity_limit import FrameVelocityLimit
    from lexstack.tasks.framed_pose import FramePose
    from lexstack.tasks.framed_position import FramePosition
    from lexstack.tasks.half_space import HalfSpace
    from lexstack.tasks.joint_coupling import JointCoupling
    from lexstack.tasks.look_at import LookAt
    from lexstack.tasks.manipulability import Manipulability
    from lexstack.tasks.options import (
        JointLimitConfig,
        LevelConfig,
        StackConfig,
        TaskConfig,
        plan_stack,
    )
    from lexstack.tasks.posture import Posture, PostureParameters, posture_target
    from lexstack.tasks.registry import TASKS, register_task
    from lexstack.tasks.relative_pose import RelativePose, cross, other_end
    from lexstack.tasks.stack import AT_REST, Level, Stack, build_limits, build_stack, joined
    from lexstack.tasks.task import Task, TaskFactory
    from lexstack.tasks.velocity_damping import VelocityDamping
else:
    __getattr__ = on_demand(
        __name__,
        {
            "axis_alignment": "AxisAlignment",
            "base_pose": "Base",
            "centre_of_mass": "CentreOfMass",
            "collision_avoidance": "CollisionAvoidance CollisionAvoidanceParameters",
            "cone": "Cone",
            "frame_orientation": "FrameOrientation",
            "frame_pose": "EePose EePoseParameters pose_error saturated",
            "frame_position": "EePosition",
            "frame_velocity_limit": "FrameVelocityLimit",
            "framed_pose": "FramePose",
            "framed_position": "FramePosition",
            "half_space": "HalfSpace",
            "joint_coupling": "JointCoupling",
            "look_at": "LookAt",
            "manipulability": "Manipulability",
            "options": "JointLimitConfig LevelConfig StackConfig TaskConfig plan_stack",
            "posture": "Posture PostureParameters posture_target",
            "registry": "TASKS register_task",
            "relative_pose": "RelativePose cross other_end",
            "stack": "AT_REST Level Stack build_limits build_stack joined",
            "task": "Task TaskFactory",
            "velocity_damping": "VelocityDamping",
        },
    )

__all__ = [
    "AT_REST",
    "TASKS",
    "AxisAlignment",
    "Base",
    "CentreOfMass",
    "CollisionAvoidance",
    "CollisionAvoidanceParameters",
    "Cone",
    "EePose",
    "EePoseParameters",
    "EePosition",
    "FrameOrientation",
    "FramePose",
    "FramePosition",
    "FrameVelocityLimit",
    "HalfSpace",
    "JointCoupling",
    "JointLimitConfig",
    "Level",
    "LevelConfig",
    "LookAt",
    "Manipulability",
    "Posture",
    "PostureParameters",
    "RelativePose",
    "Stack",
    "StackConfig",
    "Task",
    "TaskConfig",
    "TaskFactory",
    "VelocityDamping",
    "build_limits",
    "build_stack",
    "cross",
    "joined",
    "other_end",
    "plan_stack",
    "pose_error",
    "posture_target",
    "register_task",
    "saturated",
]
