"""A robot from little more than its URDF, for programs without a configuration file."""

from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.options import build
from lexstack.robots.assembly import description_path
from lexstack.robots.options import ArmConfig, BaseConfig, FrameConfig, RobotConfig, WheelsConfig
from lexstack.types import Vector

_HEIGHT = 0.5  # m, top of the platform
_RAMP = 0.01  # s, in which a joint reaches its full acceleration: that gives the limit of jerk


def mobile_manipulator(
    description: str,
    tool: str,
    home: Sequence[float],
    *,
    acceleration: float = 10.0,
    name: str = "robot",
) -> RobotConfig:
    """Return an arm of example-robot-data on a holonomic platform of 0.7 x 0.6 m.

    Position, velocity and torque limits are those of the URDF. Accelerations, the platform's
    limits and the joints' impedance are round numbers: for a robot that exists, fill in a
    ``RobotConfig``.

    Args:
        description: the URDF, a path below example-robot-data's ``robots`` folder.
        tool: the link that tasks of the end effector move.
        home: where the first joints of the URDF start, rad: they are the arm, and joints after
            them, fingers, are held at 0.
        acceleration: limit of every joint of the arm [rad/s2].
        name: of this kind of robot.

    Raises:
        ModelError: there is no such file, or it has not so many joints.
        ConfigurationError: the home is outside the joint limits.
    """
    model = pin.buildModelFromUrdf(str(description_path(description)))
    names, n = tuple(model.names[1:]), len(home)
    if not 0 < n <= len(names):
        raise ModelError(f"robot {name}: home: {description} has {len(names)} joints, got {n}")

    def of_urdf(values: Vector) -> tuple[float, ...]:
        return tuple(float(value) for value in values[:n])

    def same(value: float) -> tuple[float, ...]:
        return (value,) * n

    arm = ArmConfig(
        description=description,
        root=model.frames[1].name,
        mount=FrameConfig("base", (0.0, 0.0, _HEIGHT), (0.0, 0.0, 0.0)),
        joints=names[:n],
        fixed=dict.fromkeys(names[n:], 0.0),
        home=tuple(float(angle) for angle in home),
        position_lower=of_urdf(model.lowerPositionLimit),
        position_upper=of_urdf(model.upperPositionLimit),
        velocity=of_urdf(model.velocityLimit),
        acceleration=same(acceleration),
        jerk=same(acceleration / _RAMP),
        torque=of_urdf(model.effortLimit),
        torque_rate=same(1000.0),
        stiffness=same(200.0),
        damping=same(20.0),
        armature=same(0.1),
        q_star_distance=same(0.1),
    )
    arm = build(ArmConfig, arm, f"robot {name}: arm")
    return RobotConfig(name, _platform(), arm, FrameConfig(tool, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))


def _platform() -> BaseConfig:
    """Return a platform of 100 kg that goes at 1 m/s."""
    return BaseConfig(
        chassis_size=(0.7, 0.6, 0.4),
        chassis_height=0.3,
        chassis_mass=100.0,
        chassis_inertia=(4.3, 5.4, 7.1),  # of a homogeneous box
        wheels=WheelsConfig(radius=0.1, width=0.08, x=0.25, y=0.25, mass=5.0),
        velocity=(1.0, 1.0, 2.0),
        acceleration=(2.0, 2.0, 4.0),
        jerk=(200.0, 200.0, 400.0),
        servo_gain=(1e5, 1e5, 1e4),
        servo_force=(800.0, 800.0, 400.0),
        q_star_distance=(0.02, 0.02, 0.02),
    )
