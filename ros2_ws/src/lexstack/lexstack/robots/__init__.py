"""Robot models: one pinocchio model per robot is the single source of kinematics and inertia."""

from lexstack.robots.collision_geometry import Spheres
from lexstack.robots.kinematics import Kinematics, Pose
from lexstack.robots.obstacles import Obstacles
from lexstack.robots.robot import RobotModel
from lexstack.robots.team import Team

__all__ = ["Kinematics", "Obstacles", "Pose", "RobotModel", "Spheres", "Team"]
