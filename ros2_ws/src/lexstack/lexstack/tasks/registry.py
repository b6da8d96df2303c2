"""The tasks by the name that stack files use: one of the library is its file and one line here."""

from lexstack.options import register
from lexstack.tasks.base_pose import Base
from lexstack.tasks.collision_avoidance import CollisionAvoidance
from lexstack.tasks.frame_pose import EePose
from lexstack.tasks.frame_position import EePosition
from lexstack.tasks.posture import Posture
from lexstack.tasks.relative_pose import RelativePose
from lexstack.tasks.task import TaskFactory
from lexstack.tasks.velocity_damping import VelocityDamping

TASKS: dict[str, TaskFactory] = {
    "base": Base.from_config,
    "collision_avoidance": CollisionAvoidance.from_config,
    "ee_pose": EePose.from_config,
    "ee_position": EePosition.from_config,
    "posture": Posture.from_config,
    "relative_pose": RelativePose.from_config,
    "velocity_damping": VelocityDamping.from_config,
}
"""How each task is made, by the type that stack files name; ``register_task`` adds others."""


def register_task(name: str, factory: TaskFactory) -> None:
    """Make a task known by a name, for stack files.

    Raises:
        ConfigurationError: it is no name, or the name of another task.
    """
    register(TASKS, "task", name, factory)
