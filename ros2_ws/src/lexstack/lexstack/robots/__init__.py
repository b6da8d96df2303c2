"""Robot models: one pinocchio model per robot is the single source of kinematics and inertia."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.robots.assembly import BASE_JOINTS, build_base
    from lexstack.robots.collision_geometry import Spheres
    from lexstack.robots.description import description_path, is_text, located, urdf_text
    from lexstack.robots.from_urdf import mobile_manipulator, robot_from_urdf
    from lexstack.robots.ik import inverse_kinematics
    from lexstack.robots.kinematics import Kinematics, Pose
    from lexstack.robots.obstacles import Obstacles
    from lexstack.robots.options import (
        ArmConfig,
        BaseConfig,
        FrameConfig,
        ObstacleConfig,
        RobotConfig,
        SphereConfig,
        Vector3,
        WheelsConfig,
    )
    from lexstack.robots.robot import RobotModel
    from lexstack.robots.robot_file import ArmFile, RobotFile, completed
    from lexstack.robots.spatial import from_quaternion, from_rpy, log3, to_quaternion, wrap
    from lexstack.robots.team import Team
    from lexstack.robots.urdf import slides
else:
    __getattr__ = on_demand(
        __name__,
        {
            "assembly": "BASE_JOINTS build_base",
            "collision_geometry": "Spheres",
            "description": "description_path is_text located urdf_text",
            "from_urdf": "mobile_manipulator robot_from_urdf",
            "ik": "inverse_kinematics",
            "kinematics": "Kinematics Pose",
            "obstacles": "Obstacles",
            "options": "ArmConfig BaseConfig FrameConfig ObstacleConfig "
            "RobotConfig SphereConfig Vector3 WheelsConfig",
            "robot": "RobotModel",
            "robot_file": "ArmFile RobotFile completed",
            "spatial": "from_quaternion from_rpy log3 to_quaternion wrap",
            "team": "Team",
            "urdf": "slides",
        },
    )

__all__ = [
    "BASE_JOINTS",
    "ArmConfig",
    "ArmFile",
    "BaseConfig",
    "FrameConfig",
    "Kinematics",
    "ObstacleConfig",
    "Obstacles",
    "Pose",
    "RobotConfig",
    "RobotFile",
    "RobotModel",
    "SphereConfig",
    "Spheres",
    "Team",
    "Vector3",
    "WheelsConfig",
    "build_base",
    "completed",
    "description_path",
    "from_quaternion",
    "from_rpy",
    "inverse_kinematics",
    "is_text",
    "located",
    "log3",
    "mobile_manipulator",
    "robot_from_urdf",
    "slides",
    "to_quaternion",
    "urdf_text",
    "wrap",
]
