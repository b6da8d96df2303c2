"""Hierarchical-task MPC (H): values in, a plan out; no clock, no ROS."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.mpc.collision_cost import CollisionScene
    from lexstack.mpc.double_integrator import Horizon
    from lexstack.mpc.htmpc import Htmpc, Start
    from lexstack.mpc.measures import COLUMNS, Kind, measure_of
    from lexstack.mpc.options import (
        DEFAULT_HTMPC,
        BarrierConfig,
        CollisionConfig,
        Constraint,
        EffortConfig,
        HtmpcConfig,
        LineSearchConfig,
        TaskWeightsConfig,
    )
    from lexstack.mpc.other_robots import OtherRobot
    from lexstack.mpc.plan import Plan
    from lexstack.mpc.sequence.options import SequenceConfig, SequenceTaskConfig
    from lexstack.mpc.sequence.reach import Reach
    from lexstack.mpc.sequence.robot_pose import RobotPose
    from lexstack.mpc.sequence.runner import (
        ARCHITECTURES,
        Change,
        Progress,
        SequenceRunner,
        plans_of,
        tasks_of,
    )
    from lexstack.mpc.sequence.sequence import HT_ARCH, ST_ARCH, Architecture, Sequence, check_tasks
    from lexstack.mpc.sequence.task import SequenceTask
    from lexstack.mpc.sequence.trajectory import Trajectory, base_path, ee_path, hold, steps
    from lexstack.mpc.stage_kinematics import StageModel
    from lexstack.mpc.status import LevelStatus, Outcome
    from lexstack.mpc.symbolic import stage_function
    from lexstack.mpc.tracking_objectives import Objective, Task
else:
    __getattr__ = on_demand(
        __name__,
        {
            "collision_cost": "CollisionScene",
            "double_integrator": "Horizon",
            "htmpc": "Htmpc Start",
            "measures": "COLUMNS Kind measure_of",
            "options": "DEFAULT_HTMPC BarrierConfig CollisionConfig Constraint EffortConfig "
            "HtmpcConfig LineSearchConfig TaskWeightsConfig",
            "other_robots": "OtherRobot",
            "plan": "Plan",
            "sequence.options": "SequenceConfig SequenceTaskConfig",
            "sequence.reach": "Reach",
            "sequence.robot_pose": "RobotPose",
            "sequence.runner": "ARCHITECTURES Change Progress SequenceRunner plans_of tasks_of",
            "sequence.sequence": "HT_ARCH ST_ARCH Architecture Sequence check_tasks",
            "sequence.task": "SequenceTask",
            "sequence.trajectory": "Trajectory base_path ee_path hold steps",
            "stage_kinematics": "StageModel",
            "status": "LevelStatus Outcome",
            "symbolic": "stage_function",
            "tracking_objectives": "Objective Task",
        },
    )

__all__ = [
    "ARCHITECTURES",
    "COLUMNS",
    "DEFAULT_HTMPC",
    "HT_ARCH",
    "ST_ARCH",
    "Architecture",
    "BarrierConfig",
    "Change",
    "CollisionConfig",
    "CollisionScene",
    "Constraint",
    "EffortConfig",
    "Horizon",
    "Htmpc",
    "HtmpcConfig",
    "Kind",
    "LevelStatus",
    "LineSearchConfig",
    "Objective",
    "OtherRobot",
    "Outcome",
    "Plan",
    "Progress",
    "Reach",
    "RobotPose",
    "Sequence",
    "SequenceConfig",
    "SequenceRunner",
    "SequenceTask",
    "SequenceTaskConfig",
    "StageModel",
    "Start",
    "Task",
    "TaskWeightsConfig",
    "Trajectory",
    "base_path",
    "check_tasks",
    "ee_path",
    "hold",
    "measure_of",
    "plans_of",
    "stage_function",
    "steps",
    "tasks_of",
]
