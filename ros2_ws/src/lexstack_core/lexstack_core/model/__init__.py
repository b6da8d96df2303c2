"""Robot models: one pinocchio model per robot is the single source of kinematics and inertia."""

from lexstack_core.model.kinematics import Kinematics, Pose
from lexstack_core.model.obstacles import Obstacles
from lexstack_core.model.robot import RobotModel
from lexstack_core.model.spheres import Spheres
from lexstack_core.model.team import Team

__all__ = ["Kinematics", "Obstacles", "Pose", "RobotModel", "Spheres", "Team"]
