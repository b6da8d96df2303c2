"""The tasks, one file each, and stacks of them."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.tasks.base_pose import Base
    from lexstack.tasks.collision_avoidance import CollisionAvoidance, CollisionAvoidanceParameters
    from lexstack.tasks.frame_pose import EePose, EePoseParameters, pose_error, saturated
    from lexstack.tasks.frame_position import EePosition
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
            "base_pose": "Base",
            "collision_avoidance": "CollisionAvoidance CollisionAvoidanceParameters",
            "frame_pose": "EePose EePoseParameters pose_error saturated",
            "frame_position": "EePosition",
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
    "Base",
    "CollisionAvoidance",
    "CollisionAvoidanceParameters",
    "EePose",
    "EePoseParameters",
    "EePosition",
    "JointLimitConfig",
    "Level",
    "LevelConfig",
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
