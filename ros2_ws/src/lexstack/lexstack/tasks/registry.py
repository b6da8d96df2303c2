"""The tasks by the name that stack files use: one of the library is its file and one line here."""

from lexstack.options import register
from lexstack.tasks.axis_alignment import AxisAlignment
from lexstack.tasks.base_pose import Base
from lexstack.tasks.centre_of_mass import CentreOfMass
from lexstack.tasks.collision_avoidance import CollisionAvoidance
from lexstack.tasks.cone import Cone
from lexstack.tasks.frame_orientation import FrameOrientation
from lexstack.tasks.frame_pose import EePose
from lexstack.tasks.frame_position import EePosition
from lexstack.tasks.frame_velocity_limit import FrameVelocityLimit
from lexstack.tasks.framed_pose import FramePose
from lexstack.tasks.framed_position import FramePosition
from lexstack.tasks.half_space import HalfSpace
from lexstack.tasks.joint_coupling import JointCoupling
from lexstack.tasks.look_at import LookAt
from lexstack.tasks.manipulability import Manipulability
from lexstack.tasks.posture import Posture
from lexstack.tasks.relative_pose import RelativePose
from lexstack.tasks.task import TaskFactory
from lexstack.tasks.velocity_damping import VelocityDamping

TASKS: dict[str, TaskFactory] = {
    "axis_alignment": AxisAlignment.from_config,
    "base": Base.from_config,
    "centre_of_mass": CentreOfMass.from_config,
    "collision_avoidance": CollisionAvoidance.from_config,
    "cone": Cone.from_config,
    "ee_pose": EePose.from_config,
    "ee_position": EePosition.from_config,
    "frame_orientation": FrameOrientation.from_config,
    "frame_pose": FramePose.from_config,
    "frame_position": FramePosition.from_config,
    "frame_velocity_limit": FrameVelocityLimit.from_config,
    "half_space": HalfSpace.from_config,
    "joint_coupling": JointCoupling.from_config,
    "look_at": LookAt.from_config,
    "manipulability": Manipulability.from_config,
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
