"""What a robot is built from, every value of it stated; and what an obstacle is.

A robot's file may leave most of this out: ``robot_file.py`` has its schema, and fills in the rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from lexstack.errors import ConfigurationError
from lexstack.options import Finite, Finite3, NotNegative, Positive, Range, same_length

Vector3 = tuple[float, float, float]
"""Along x, y, z; of a platform x, y, yaw."""

_Positive3 = tuple[Positive, Positive, Positive]
_Positive2 = tuple[Positive, Positive]

# The lists of an arm that have one entry per joint.
_PER_JOINT = (
    *("home", "position_lower", "position_upper", "velocity", "acceleration", "jerk", "torque"),
    *("torque_rate", "stiffness", "damping", "armature", "q_star_distance"),
)


@dataclass(frozen=True, slots=True)
class FrameConfig:
    """A fixed frame: its parent link, and its pose in the parent's frame."""

    parent: str  # name of a link
    xyz: Vector3 = (0.0, 0.0, 0.0)  # m
    rpy: Vector3 = (0.0, 0.0, 0.0)  # rad, roll pitch yaw about fixed axes


@dataclass(frozen=True, slots=True)
class WheelsConfig:
    """Four wheels, for the eye only: they carry no load in the planar model."""

    radius: float = 0.1  # m
    width: float = 0.08  # m
    x: float = 0.25  # m, centre to axle
    y: float = 0.25  # m, centre to wheel
    mass: float = 5.0  # kg, each


@dataclass(frozen=True, slots=True)
class Platform:
    """Chassis and wheels of a base, which the simulation alone needs.

    By default those of a platform of 0.7 x 0.6 m and 120 kg.
    """

    chassis_size: _Positive3 = (0.7, 0.6, 0.4)  # m, length x width x height of the box
    chassis_height: float = 0.3  # m, box centre above the floor
    chassis_mass: NotNegative = 100.0  # kg; 0: the URDF has the chassis, no box and wheels here
    # kg m2, about the box centre: ixx, iyy, izz; the default is a homogeneous box's
    chassis_inertia: _Positive3 = (4.3, 5.4, 7.1)
    wheels: WheelsConfig = field(default_factory=WheelsConfig)  # four of them


@dataclass(frozen=True, slots=True)
class BaseConfig(Platform):
    """A holonomic platform: planar joints x, y, yaw with velocity servos.

    The control needs its velocity, acceleration and jerk alone. Chassis, wheels, servos and
    ``q_star_distance`` are the simulation's; by default they are those of a platform of 0.7 x 0.6 m
    and 120 kg.
    """

    velocity: _Positive3 = (1.0, 1.0, 2.0)  # m/s, m/s, rad/s
    acceleration: _Positive3 = (2.0, 2.0, 4.0)  # m/s2, m/s2, rad/s2
    jerk: _Positive3 = (200.0, 200.0, 400.0)  # m/s3, m/s3, rad/s3
    servo_gain: _Positive3 = (1e5, 1e5, 1e4)  # N s/m, N s/m, N m s/rad
    servo_force: _Positive3 = (800.0, 800.0, 400.0)  # N, N, N m
    q_star_distance: _Positive3 = (0.02, 0.02, 0.02)  # m, m, rad: how far q* may run from q
    type: Literal["holonomic"] = "holonomic"  # which velocities it takes


@dataclass(frozen=True, slots=True)
class DifferentialConfig(Platform):
    """A platform that drives ahead or back and turns, but never goes sideways.

    Its commanded velocities are v [m/s], along its heading, and w [rad/s]: every list has these
    two. The control needs its velocity, acceleration and jerk alone, as that of ``BaseConfig``.
    """

    velocity: _Positive2 = (1.0, 2.0)  # m/s, rad/s
    acceleration: _Positive2 = (2.0, 4.0)  # m/s2, rad/s2
    jerk: _Positive2 = (200.0, 400.0)  # m/s3, rad/s3
    servo_gain: _Positive2 = (1e5, 1e4)  # N s/m, N m s/rad
    servo_force: _Positive2 = (800.0, 400.0)  # N, N m
    q_star_distance: _Positive2 = (0.02, 0.02)  # m, rad: how far q* may run from q
    type: Literal["differential"] = "differential"  # which velocities it takes


AnyBase = BaseConfig | DifferentialConfig
"""A base of any type, as its ``type`` says."""


def along_axes(values: tuple[float, ...]) -> tuple[float, float, float]:
    """Return values of a base along x, y and yaw: those along v and w count in every direction."""
    if len(values) == 2:
        return values[0], *values
    return values[0], values[1], values[2]


@dataclass(frozen=True, slots=True)
class ArmConfig:
    """All that a URDF moves, one arm or several on a torso, with its limits and impedance.

    For a prismatic joint read m where a list says rad, and N where it says N m. A planar joint P of
    the URDF is three joints, P_x, P_y [m] and P_yaw [rad]. Joints that mimic another follow it and
    are named nowhere, unless ``fixed`` holds one.
    """

    description: str  # a URDF: path, package://NAME/..., text, or below example-robot-data's robots
    root: str  # the link that is mounted on the base; it must not move
    mount: FrameConfig  # parent: base
    joints: tuple[str, ...]  # controlled joints, in the order of chi
    fixed: dict[str, float]  # the other joints of the URDF and where they are held [rad or m]
    home: tuple[Finite, ...]  # rad
    position_lower: tuple[float, ...]  # rad; -inf and inf: without limits, as continuous joints
    position_upper: tuple[float, ...]  # rad
    velocity: tuple[Positive, ...]  # rad/s
    acceleration: tuple[Positive, ...]  # rad/s2
    jerk: tuple[Positive, ...]  # rad/s3
    torque: tuple[Positive, ...]  # N m
    torque_rate: tuple[Positive, ...]  # N m/s
    stiffness: tuple[Positive, ...]  # K_qp of T(40) [N m/rad]
    damping: tuple[NotNegative, ...]  # K_qd of T(40) [N m s/rad]
    armature: tuple[NotNegative, ...]  # kg m2, rotor inertia seen at the joint
    q_star_distance: tuple[Positive, ...]  # rad: how far q* may run from q
    # rad: where the task ``posture`` leads by default, away from singularities; None: mid-range,
    # which is often singular
    posture: tuple[Finite, ...] | None = None
    packages: tuple[str, ...] = ()  # absolute folders of packages, for the meshes of package://

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a list of the wrong length, or angles out of range."""
        same_length(where, len(self.joints), **{name: getattr(self, name) for name in _PER_JOINT})
        if self.posture is not None:
            same_length(where, len(self.joints), posture=self.posture)
        for i, name in enumerate(self.joints):
            _check_limits(f"{where}: {name}", self.position_lower[i], self.position_upper[i])
            for key in ("home", "posture"):
                values = getattr(self, key)
                if values and not self.position_lower[i] <= values[i] <= self.position_upper[i]:
                    raise ConfigurationError(
                        f"{where}: {name}: {key} is outside the position limits"
                    )


def _check_limits(where: str, lower: float, upper: float) -> None:
    """Raise ConfigurationError unless a joint's limits are a range, or it has none at all."""
    if (lower, upper) == (-math.inf, math.inf):
        return
    for key, value in (("position_lower", lower), ("position_upper", upper)):
        Range().check(value, f"{where}: {key}")
    if not lower < upper:
        raise ConfigurationError(f"{where}: position_lower >= position_upper")


@dataclass(frozen=True, slots=True)
class SphereConfig:
    """A sphere on a link: together they stand for the robot where distances are kept."""

    link: str  # base, or a link of the arm
    xyz: Finite3  # m, its centre in the link's frame
    radius: Positive  # m


@dataclass(frozen=True, slots=True)
class RobotConfig:
    """One kind of robot: base, arm, and the frames that end-effector tasks move."""

    name: str  # of its file
    base: AnyBase | None  # None: it stands on a table or hangs on a wall, and does not drive
    arm: ArmConfig  # what moves but the base
    tool: FrameConfig  # parent: a link of the arm; the frame ``tool``, the default end effector
    spheres: tuple[SphereConfig, ...] = ()  # none: it takes no part in any distance
    tools: dict[str, FrameConfig] = field(default_factory=dict)  # other end effectors, by name


@dataclass(frozen=True, slots=True)
class ObstacleConfig:
    """A sphere in the robots' way: everybody knows where it is at any time.

    Its centre is at position + velocity t + swing (1 - cos(2 pi t / period)) / 2.
    """

    position: Finite3  # m, of its centre at time 0, world frame
    radius: Positive  # m
    velocity: Finite3 = (0.0, 0.0, 0.0)  # m/s, constant
    swing: Finite3 = (0.0, 0.0, 0.0)  # m, how far it goes beside that, and comes back
    period: Positive = 10.0  # s, of the swing: there and back, at rest at both ends
