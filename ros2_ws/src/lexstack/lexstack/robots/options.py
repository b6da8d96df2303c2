"""What a robot is built from: one mobile manipulator; and what an obstacle is."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.errors import ConfigurationError
from lexstack.options import Finite, Finite3, NotNegative, Positive, same_length

Vector3 = tuple[float, float, float]
"""Along x, y, z; of a platform x, y, yaw."""

_Positive3 = tuple[Positive, Positive, Positive]

# The lists of an arm that have one entry per joint.
_PER_JOINT = (
    *("home", "position_lower", "position_upper", "velocity", "acceleration", "jerk", "torque"),
    *("torque_rate", "stiffness", "damping", "armature", "q_star_distance"),
)


@dataclass(frozen=True, slots=True)
class FrameConfig:
    """A fixed frame: its parent link, and its pose in the parent's frame."""

    parent: str  # name of a link
    xyz: Vector3  # m
    rpy: Vector3  # rad, roll pitch yaw about fixed axes


@dataclass(frozen=True, slots=True)
class WheelsConfig:
    """Four wheels, for the eye only: they carry no load in the planar model."""

    radius: float  # m
    width: float  # m
    x: float  # m, centre to axle
    y: float  # m, centre to wheel
    mass: float  # kg, each


@dataclass(frozen=True, slots=True)
class BaseConfig:
    """A holonomic platform: planar joints x, y, yaw with velocity servos."""

    chassis_size: _Positive3  # m, length x width x height of the box
    chassis_height: float  # m, box centre above the floor
    chassis_mass: Positive  # kg
    chassis_inertia: _Positive3  # kg m2, about the box centre: ixx, iyy, izz
    wheels: WheelsConfig  # four of them
    velocity: _Positive3  # m/s, m/s, rad/s
    acceleration: _Positive3  # m/s2, m/s2, rad/s2
    jerk: _Positive3  # m/s3, m/s3, rad/s3
    servo_gain: _Positive3  # N s/m, N s/m, N m s/rad
    servo_force: _Positive3  # N, N, N m
    q_star_distance: _Positive3  # m, m, rad: how far q* may run from q


@dataclass(frozen=True, slots=True)
class ArmConfig:
    """An arm from a URDF of the package ``example_robot_data``, with its limits and impedance.

    For a prismatic joint read m where a list says rad, and N where it says N m.
    """

    description: str  # path below example_robot_data's robots folder
    root: str  # the link that is mounted on the base
    mount: FrameConfig  # parent: base
    joints: tuple[str, ...]  # controlled joints, in the order of chi
    fixed: dict[str, float]  # the other joints of the URDF and where they are held [rad or m]
    home: tuple[Finite, ...]  # rad
    position_lower: tuple[Finite, ...]  # rad
    position_upper: tuple[Finite, ...]  # rad
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

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a list of the wrong length, or angles out of range."""
        same_length(where, len(self.joints), **{name: getattr(self, name) for name in _PER_JOINT})
        if self.posture is not None:
            same_length(where, len(self.joints), posture=self.posture)
        for i, name in enumerate(self.joints):
            if not self.position_lower[i] < self.position_upper[i]:
                raise ConfigurationError(f"{where}: {name}: position_lower >= position_upper")
            for key in ("home", "posture"):
                values = getattr(self, key)
                if values and not self.position_lower[i] <= values[i] <= self.position_upper[i]:
                    raise ConfigurationError(
                        f"{where}: {name}: {key} is outside the position limits"
                    )


@dataclass(frozen=True, slots=True)
class SphereConfig:
    """A sphere on a link: together they stand for the robot where distances are kept."""

    link: str  # base, or a link of the arm
    xyz: Finite3  # m, its centre in the link's frame
    radius: Positive  # m


@dataclass(frozen=True, slots=True)
class RobotConfig:
    """One kind of robot: base, arm, and the tool frame that end-effector tasks move."""

    name: str  # of its file
    base: BaseConfig  # the platform
    arm: ArmConfig  # what it carries
    tool: FrameConfig  # parent: a link of the arm
    spheres: tuple[SphereConfig, ...] = ()  # none: it takes no part in any distance


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
