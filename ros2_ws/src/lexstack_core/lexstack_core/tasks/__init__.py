"""The tasks: one file each, registered here by the name that stack files use."""

from lexstack_core.tasks.base import Base
from lexstack_core.tasks.distance import Distance
from lexstack_core.tasks.ee_pose import EePose
from lexstack_core.tasks.ee_position import EePosition
from lexstack_core.tasks.minimum_velocity import MinimumVelocity
from lexstack_core.tasks.posture import Posture
from lexstack_core.tasks.relative_pose import RelativePose
from lexstack_core.tasks.task import Task, TaskFactory

TASKS: dict[str, TaskFactory] = {
    "base": Base.from_config,
    "distance": Distance.from_config,
    "ee_pose": EePose.from_config,
    "ee_position": EePosition.from_config,
    "minimum_velocity": MinimumVelocity.from_config,
    "posture": Posture.from_config,
    "relative_pose": RelativePose.from_config,
}
"""How each task is made, by the type that stack files name."""

__all__ = ["TASKS", "Task", "TaskFactory"]
