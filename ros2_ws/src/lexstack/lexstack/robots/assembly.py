"""Where robot descriptions lie, and how a base and an arm become one pinocchio model."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.robots.options import BaseConfig, FrameConfig, RobotConfig
from lexstack.robots.spatial import from_rpy

BASE_JOINTS = ("base_x", "base_y", "base_yaw")
"""Names of the platform's joints, the first three of every robot."""


@cache  # every robot of a team asks, and the package has thousands of files
def description_path(relative: str) -> Path:
    """Return a file of the package ``example-robot-data``, by its path below ``robots/``."""
    try:
        listed = files("example-robot-data") or []
    except PackageNotFoundError as error:
        raise ModelError("the package example-robot-data is not installed") from error
    for entry in listed:
        if entry.as_posix().endswith(f"robots/{relative}"):
            return Path(str(entry.locate())).resolve()
    raise ModelError(f"example-robot-data has no file {relative!r} below robots/")


def placement(frame: FrameConfig) -> pin.SE3:
    """Return a configured frame as a placement in its parent."""
    return pin.SE3(from_rpy(frame.rpy), np.array(frame.xyz))


def build_arm(config: RobotConfig) -> pin.Model:
    """Return the arm of a URDF alone, its other joints locked as configured, root at the origin.

    Raises:
        ModelError: a joint of the configuration is not in the URDF, or one is not accounted for.
    """
    arm = config.arm
    path = description_path(arm.description)
    full = pin.buildModelFromUrdf(str(path))
    for joint in (*arm.joints, *arm.fixed):
        if not full.existJointName(joint):
            raise ModelError(f"robot {config.name}: {path.name} has no joint {joint!r}")
    posture = pin.neutral(full)
    for joint, value in arm.fixed.items():
        posture[full.joints[full.getJointId(joint)].idx_q] = value
    locked = [full.getJointId(joint) for joint in arm.fixed]
    model = pin.buildReducedModel(full, locked, posture)
    if tuple(model.names[1:]) != arm.joints:
        raise ModelError(
            f"robot {config.name}: joints {arm.joints} are not the movable joints of {path.name} "
            f"in order: {tuple(model.names[1:])}"
        )
    for frame in model.frames:
        if frame.name == "base":  # the URDF of the UR10 has one; ours is the platform's
            frame.name = "arm_base"
    return model


def build_base(base: BaseConfig) -> pin.Model:
    """Return the platform alone: x, y, yaw in the world frame, chassis and wheels as one body."""
    model = pin.Model()
    identity = pin.SE3.Identity()
    parent = 0
    for joint, name in zip(
        (pin.JointModelPX(), pin.JointModelPY(), pin.JointModelRZ()), BASE_JOINTS, strict=True
    ):
        parent = model.addJoint(parent, joint, identity, name)
    chassis = pin.Inertia(
        base.chassis_mass,
        np.array([0.0, 0.0, base.chassis_height]),
        np.diag(np.array(base.chassis_inertia)),
    )
    model.appendBodyToJoint(parent, chassis, identity)
    wheels = base.wheels
    for x in (wheels.x, -wheels.x):
        for y in (wheels.y, -wheels.y):
            cylinder = pin.Inertia.FromCylinder(wheels.mass, wheels.radius, wheels.width)
            upright = pin.SE3(from_rpy((np.pi / 2, 0.0, 0.0)), np.array([x, y, wheels.radius]))
            model.appendBodyToJoint(parent, cylinder, upright)
    model.addFrame(pin.Frame("base", parent, 0, identity, pin.FrameType.BODY))
    return model


def build_robot(config: RobotConfig) -> pin.Model:
    """Return base and arm as one model, with the frame ``tool``; positions (x, y, yaw, arm).

    Raises:
        ModelError: a frame of the configuration does not exist.
    """
    base, arm = build_base(config.base), build_arm(config)
    if config.arm.mount.parent != "base":
        raise ModelError(f"robot {config.name}: arm.mount.parent: only 'base' is there")
    model = pin.appendModel(base, arm, base.getFrameId("base"), placement(config.arm.mount))
    # appendModel drops the armature of both, so it is set on the whole.
    model.armature = np.concatenate([np.zeros(base.nv), config.arm.armature])
    if not model.existFrame(config.tool.parent):
        raise ModelError(f"robot {config.name}: tool.parent: no link {config.tool.parent!r}")
    parent = model.getFrameId(config.tool.parent)
    frame = model.frames[parent]
    model.addFrame(
        pin.Frame(
            "tool",
            frame.parentJoint,
            parent,
            frame.placement * placement(config.tool),
            pin.FrameType.OP_FRAME,
        )
    )
    return model
