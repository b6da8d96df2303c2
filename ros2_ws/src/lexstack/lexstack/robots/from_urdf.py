"""A robot from little more than its URDF, for programs without a configuration file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.options import build
from lexstack.robots.description import located
from lexstack.robots.options import AnyBase, BaseConfig, FrameConfig, RobotConfig, SphereConfig
from lexstack.robots.robot import RobotModel
from lexstack.robots.robot_file import RAMP, ArmFile, RobotFile, completed
from lexstack.robots.urdf import Description, one_coordinate, read_urdf

_HEIGHT = 0.5  # m, top of the platform


def robot_from_urdf(
    description: str | Path | pin.Model,
    *,
    name: str = "robot",
    base: AnyBase | None = None,
    tool: str | None = None,
    tools: Mapping[str, str] | None = None,
    place: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
    spheres: Sequence[SphereConfig] = (),
    **arm: Any,
) -> RobotModel:
    """Return the robot that a URDF describes.

    Args:
        description: a path, ``package://NAME/...``, a text, a path below example-robot-data's
            ``robots`` folder, or a model of pinocchio, in which no joint mimics another.
        name: of the robot.
        base: a platform that it stands on; None: it is mounted at ``place``.
        tool: the link of the default end effector; default: the last one of the only chain.
        tools: links of other end effectors, by name.
        place: x, y, z [m], yaw [rad] of the mounting of a robot without a base.
        spheres: that stand for it where distances are kept.
        arm: other values of ``ArmFile``, such as ``joints=[...]`` or ``acceleration=5.0``.

    Raises:
        ConfigurationError: a value is missing or wrong; the text names key and joint.
        ModelError: a frame is not there.
    """
    given, path = None, str(description)
    if isinstance(description, pin.Model):
        model, continuous = one_coordinate(description, "the model")
        given, path = Description(model, {}, continuous), ""
    where = f"robot {name}"
    file = RobotFile(
        name,
        replace(build(ArmFile, {"description": "", **arm}, f"{where}: arm"), description=path),
        base,
        None if tool is None else FrameConfig(tool),
        {key: FrameConfig(link) for key, link in (tools or {}).items()},
        tuple(build(SphereConfig, sphere, f"{where}: spheres") for sphere in spheres),
    )
    return RobotModel(name, completed(file, where, None, given), place, given)


def mobile_manipulator(
    description: str,
    tool: str,
    home: Sequence[float],
    *,
    acceleration: float = 10.0,
    name: str = "robot",
) -> RobotConfig:
    """Return an arm on a holonomic platform of 0.7 x 0.6 m.

    Position, velocity and torque limits are those of the URDF. Accelerations, the platform's
    limits and the joints' impedance are round numbers: for a robot that exists, fill in a
    ``RobotConfig``.

    Args:
        description: the URDF, as ``robot_from_urdf`` takes it, but for a model.
        tool: the link that tasks of the end effector move.
        home: where the first joints of the URDF start, rad: they are the arm, and joints after
            them, fingers, are held at 0.
        acceleration: limit of every joint of the arm [rad/s2].
        name: of this kind of robot.

    Raises:
        ModelError: there is no such file, or it has not so many joints.
        ConfigurationError: the home is outside the joint limits.
    """
    names, n = _joints(description), len(home)
    if not 0 < n <= len(names):
        raise ModelError(f"robot {name}: home: {description} has {len(names)} joints, got {n}")
    arm = ArmFile(
        description,
        mount=FrameConfig("base", (0.0, 0.0, _HEIGHT)),
        joints=names[:n],
        fixed=dict.fromkeys(names[n:], 0.0),
        home=tuple(float(angle) for angle in home),
        acceleration=acceleration,
        jerk=acceleration / RAMP,
    )
    file = RobotFile(name, arm, BaseConfig(), FrameConfig(tool))
    return completed(file, f"robot {name}")


def _joints(description: str) -> tuple[str, ...]:
    """Return the joints of a URDF, all that move; raises ModelError where it cannot be read."""
    return tuple(read_urdf(located(description)).model.names[1:])
