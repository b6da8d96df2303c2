"""Robot models: one pinocchio model per robot is the single source of kinematics and inertia."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.robots.assembly import BASE_JOINTS, DRIVE, TOOL, build_base
    from lexstack.robots.collision_geometry import Spheres
    from lexstack.robots.configuration import Configuration, FrameAt
    from lexstack.robots.description import description_path, is_text, located, urdf_text
    from lexstack.robots.from_urdf import mobile_manipulator, robot_from_urdf
    from lexstack.robots.handle import Robot
    from lexstack.robots.ik import inverse_kinematics
    from lexstack.robots.kinematics import Kinematics, Pose
    from lexstack.robots.obstacles import Obstacles
    from lexstack.robots.options import (
        AnyBase,
        ArmConfig,
        BaseConfig,
        DifferentialConfig,
        FrameConfig,
        ObstacleConfig,
        RobotConfig,
        SphereConfig,
        Vector3,
        WheelsConfig,
        along_axes,
    )
    from lexstack.robots.robot import RobotModel
    from lexstack.robots.robot_file import ArmFile, RobotFile, completed
    from lexstack.robots.spatial import from_quaternion, from_rpy, log3, to_quaternion, wrap
    from lexstack.robots.sphere_fit import Covering, cover
    from lexstack.robots.team import Team
    from lexstack.robots.unicycle import arc
    from lexstack.robots.urdf import slides
else:
    __getattr__ = on_demand(
        __name__,
        {
            "assembly": "BASE_JOINTS DRIVE TOOL build_base",
            "collision_geometry": "Spheres",
            "configuration": "Configuration FrameAt",
            "description": "description_path is_text located urdf_text",
            "from_urdf": "mobile_manipulator robot_from_urdf",
            "handle": "Robot",
            "ik": "inverse_kinematics",
            "kinematics": "Kinematics Pose",
            "obstacles": "Obstacles",
            "options": "AnyBase ArmConfig BaseConfig DifferentialConfig FrameConfig ObstacleConfig "
            "RobotConfig SphereConfig Vector3 WheelsConfig along_axes",
            "robot": "RobotModel",
            "robot_file": "ArmFile RobotFile completed",
            "spatial": "from_quaternion from_rpy log3 to_quaternion wrap",
            "sphere_fit": "Covering cover",
            "team": "Team",
            "unicycle": "arc",
            "urdf": "slides",
        },
    )

__all__ = [
    "BASE_JOINTS",
    "DRIVE",
    "TOOL",
    "AnyBase",
    "ArmConfig",
    "ArmFile",
    "BaseConfig",
    "Configuration",
    "Covering",
    "DifferentialConfig",
    "FrameAt",
    "FrameConfig",
    "Kinematics",
    "ObstacleConfig",
    "Obstacles",
    "Pose",
    "Robot",
    "RobotConfig",
    "RobotFile",
    "RobotModel",
    "SphereConfig",
    "Spheres",
    "Team",
    "Vector3",
    "WheelsConfig",
    "along_axes",
    "arc",
    "build_base",
    "completed",
    "cover",
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
