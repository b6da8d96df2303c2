"""The schema of ``config/plants/*.yaml``: the topics of robots that ros2_control drives."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from lexstack.errors import ConfigurationError
from lexstack.options import Finite3, Name, NotEmpty, Pattern, Positive, Range, RosName, shown
from lexstack_config.folders import Folders
from lexstack_config.reader import build, read_yaml
from lexstack_config.resolved import ResolvedScenario

Topic = Annotated[
    str, Pattern(r"/?\w{1,64}(/\w{1,64}){0,9}", "a topic has a ROS name, like /arm_1/joint_states")
]
FrameName = Annotated[str, Pattern(r"[^\s/][^\s]{0,199}", "a frame of /tf, like base_link")]


@dataclass(frozen=True, slots=True)
class JointStatesConfig:
    """Where a robot's joints are measured: sensor_msgs/JointState, in any order."""

    topic: Topic = "/joint_states"  # may carry the joints of others too
    # by the name of a joint in the robot's file: its name in messages; others are equal
    names: dict[str, str] = field(default_factory=dict)
    # whether the stamps of the messages tell when they were measured; else their arrival does
    stamps: bool = True


@dataclass(frozen=True, slots=True)
class BaseTransformConfig:
    """A platform's pose on /tf, through any number of transforms."""

    frame: FrameName = "base_link"  # of the platform: the point that its twist is about
    parent: FrameName = "odom"  # in which its pose is taken
    topic: Topic = "/tf"  # tf2_msgs/TFMessage; with _static behind it, those that do not move


@dataclass(frozen=True, slots=True)
class BaseInterfaceConfig:
    """How a platform is measured, by odometry, /tf or both, and driven."""

    command: Topic  # takes its velocity, in the axes of the base
    odometry: Topic | None = None  # nav_msgs/Odometry
    # the pose from /tf; velocities are then the odometry's, or follow from poses without one
    tf: BaseTransformConfig | None = None
    type: Literal["twist", "twist_stamped"] = "twist_stamped"  # of the command
    # in whose axes the odometry's twist is: REP-105 says the base's (child_frame_id)
    twist_axes: Literal["base", "parent"] = "base"
    frame: str = ""  # header.frame_id that the odometry must have; empty: any
    # x [m], y [m], yaw [rad] in the world of the frame that poses are in; default: the robot stands
    # where the scenario puts it when it is enabled for the first time
    origin: Finite3 | None = None

    def validate(self, where: str) -> None:
        """Raise ConfigurationError where nothing tells the pose."""
        if self.odometry is None and self.tf is None:
            raise ConfigurationError(f"{where}: odometry or tf is needed, for the platform's pose")


@dataclass(frozen=True, slots=True)
class ArmInterfaceConfig:
    """How an arm is driven."""

    command: Topic  # of its controller
    # joint_trajectory: trajectory_msgs/JointTrajectory; the others: std_msgs/Float64MultiArray
    type: Literal["joint_trajectory", "velocity", "position", "effort"] = "joint_trajectory"
    # points of a trajectory that the next message does not change any more: so many periods late
    # a message may come
    ahead: Annotated[int, Range(1, 10)] = 2
    gravity: bool = True  # effort: whether it holds the arm's weight; false: the robot does


@dataclass(frozen=True, slots=True)
class RobotInterfaceConfig:
    """One robot's topics."""

    model: Name  # a name of config/robots; the scenario's must be the same
    arm: ArmInterfaceConfig  # where its commands go
    joint_states: JointStatesConfig = field(default_factory=JointStatesConfig)  # of the arm
    base: BaseInterfaceConfig | None = None  # of a robot that drives


@dataclass(frozen=True, slots=True)
class SafetyConfig:
    """When the robots are braked and disabled."""

    stale: Positive = 0.1  # s, age of a measured state
    silence: Positive = 1.0  # s without commands of the controller, after the watchdog has braked
    # rad and m, by which measured positions may be beyond their limits, or jump
    position: Positive = 0.02
    speed: Annotated[Positive, Range(least=1.0)] = 1.2  # measured velocity / limit
    following: Positive = 0.2  # rad and m, between what is commanded and what is measured
    stop: Topic | None = None  # std_msgs/Bool of an emergency stop: true while it is pressed


@dataclass(frozen=True, slots=True)
class PlantFile:
    """A plant of robots that ros2_control drives, for ``plant_adapter``."""

    name: Name  # of the file
    description: str  # in a sentence
    robots: Annotated[  # by the names that the scenario uses
        dict[RosName, RobotInterfaceConfig], NotEmpty("at least one robot is needed")
    ]
    # Hz, ticks per second, in place of the scenario's
    rate: Annotated[Positive, Range(most=1000.0)] = 100.0
    safety: SafetyConfig = field(default_factory=SafetyConfig)  # when robots are braked
    # whether time is that of /clock, as in Gazebo; else the wall's
    use_sim_time: bool = False


def load_plant(path: Path) -> PlantFile:
    """Return one plant file; raises ConfigurationError with file and key."""
    config = build(PlantFile, read_yaml(path), str(path))
    if config.name != path.stem:
        raise ConfigurationError(f"{path}: name: expected {path.stem!r}, got {shown(config.name)}")
    return config


def find_plant(named: str, folders: Folders) -> Path:
    """Return the file that a command names: a path, or a name in the configuration folders."""
    path = Path(named)
    return path if path.suffix == ".yaml" else folders.find("plants", named)


def check_plant(plant: PlantFile, resolved: ResolvedScenario, where: str) -> None:
    """Raise ConfigurationError unless a plant has the robots of a scenario."""
    scenario = resolved.scenario
    absent = [name for name in scenario.robots if name not in plant.robots]
    if absent:
        raise ConfigurationError(
            f"{where}: robots: scenario {scenario.name} has {absent[0]!r}, but there is: "
            f"{', '.join(plant.robots)}"
        )
    for name, placement in scenario.robots.items():
        robot, key = plant.robots[name], f"{where}: robots.{name}"
        if robot.model != placement.model:
            raise ConfigurationError(
                f"{key}.model: the scenario's robot is a {placement.model!r}, "
                f"not a {shown(robot.model)}"
            )
        model = resolved.robots[robot.model]
        if (model.base is None) != (robot.base is None):
            what = "has none" if model.base is None else "is missing here"
            raise ConfigurationError(f"{key}.base: the base of {robot.model!r} {what}")
        unknown = [joint for joint in robot.joint_states.names if joint not in model.arm.joints]
        if unknown:
            raise ConfigurationError(
                f"{key}.joint_states.names: {robot.model!r} has no joint {shown(unknown[0])}"
            )
