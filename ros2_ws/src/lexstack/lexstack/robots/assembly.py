"""How a base and what a URDF moves become one pinocchio model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.options import shown
from lexstack.robots.mimics import Mimic, followed
from lexstack.robots.options import AnyBase, ArmConfig, FrameConfig, RobotConfig
from lexstack.robots.spatial import from_rpy
from lexstack.robots.urdf import Description, read_urdf

BASE_JOINTS = ("base_x", "base_y", "base_yaw")
"""Names of a platform's joints in the model, the first three of a robot that has one."""

DRIVE = ("base_v", "base_w")
"""Names of the velocities that a differential base is commanded by: along its heading, and yaw."""

_LINK = " (link)"

TOOL = "tool"
"""The frame of a robot's default end effector."""


def placement(frame: FrameConfig) -> pin.SE3:
    """Return a configured frame as a placement in its parent."""
    return pin.SE3(from_rpy(frame.rpy), np.array(frame.xyz))


def build_arm(config: RobotConfig, description: Description) -> tuple[pin.Model, dict[str, Mimic]]:
    """Return what a URDF moves, its other joints locked as configured, its root at the origin.

    Returns:
        the model of controlled joints and of those that follow one, and who follows whom.

    Raises:
        ModelError: a joint of the configuration is not in the URDF, or one is not accounted for.
    """
    arm, full = config.arm, _without_twins(description.model)
    for joint in (*arm.joints, *arm.fixed):
        if not full.existJointName(joint):
            raise ModelError(f"robot {config.name}: the URDF has no joint {joint!r}")
    mimics = {name: mimic for name, mimic in description.mimics.items() if name not in arm.fixed}
    held = held_joints(arm, mimics)
    posture = pin.neutral(full)
    for joint, value in held.items():
        posture[full.joints[full.getJointId(joint)].idx_q] = value
    model = pin.buildReducedModel(full, [full.getJointId(joint) for joint in held], posture)
    moving = tuple(name for name in model.names[1:] if name not in mimics)
    if set(moving) != set(arm.joints) or len(moving) != len(arm.joints):
        raise ModelError(
            f"robot {config.name}: joints {arm.joints} are not the movable joints of the URDF: "
            f"{moving}"
        )
    for i, joint in enumerate(arm.joints):
        after = {model.names[k] for k in model.supports[model.getJointId(joint)]}
        late = next((name for name in arm.joints[i + 1 :] if name in after), None)
        if late is not None:  # how tasks bend is worked out along the chain, in the order of chi
            raise ModelError(
                f"robot {config.name}: arm.joints: {late!r} carries {joint!r} and must come first"
            )
    return model, {name: mimics[name] for name in model.names[1:] if name in mimics}


def _without_twins(full: pin.Model) -> pin.Model:
    """Return a model in which no link and joint have the same name, as a URDF's may.

    Pinocchio looks frames up by name alone when it locks joints or appends models. So such a link
    has another name meanwhile; ``build_robot`` gives it its own again.
    """
    names = [frame.name for frame in full.frames]
    if len(set(names)) == len(names):
        return full
    model = full.copy()
    for frame in model.frames:
        if frame.type == pin.BODY and names.count(frame.name) > 1:
            frame.name += _LINK
    return model


def held_joints(arm: ArmConfig, mimics: Mapping[str, Mimic]) -> dict[str, float]:
    """Return where joints are held, rad or m: those of ``fixed``, and those that follow them."""
    held = dict(arm.fixed)
    for name in mimics:
        primary = followed(name, mimics)
        if primary.joint in arm.fixed:
            held[name] = primary.multiplier * arm.fixed[primary.joint] + primary.offset
    return held


def build_base(base: AnyBase) -> pin.Model:
    """Return the platform alone: x, y, yaw in the world frame, chassis and wheels as one body."""
    model = pin.Model()
    identity = pin.SE3.Identity()
    parent = 0
    for joint, name in zip(
        (pin.JointModelPX(), pin.JointModelPY(), pin.JointModelRZ()), BASE_JOINTS, strict=True
    ):
        parent = model.addJoint(parent, joint, identity, name)
    model.addFrame(pin.Frame("base", parent, 0, identity, pin.FrameType.BODY))
    if base.chassis_mass == 0.0:
        return model  # the URDF has them
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
    return model


def build_mounting(mounting: pin.SE3) -> pin.Model:
    """Return a model without joints: the frame ``mounting``, on which an arm without base stands.

    Args:
        mounting: its placement in the world.
    """
    model = pin.Model()
    model.addFrame(pin.Frame("mounting", 0, 0, mounting, pin.FrameType.OP_FRAME))
    return model


def build_robot(
    config: RobotConfig, mounting: pin.SE3 | None = None, description: Description | None = None
) -> tuple[pin.Model, dict[str, Mimic]]:
    """Return base and arm as one model, with the frame ``tool`` and those of ``tools``.

    Args:
        config: of the robot.
        mounting: where a robot without a base stands in the world; None: at the world's origin.
        description: in place of the one that the configuration names.

    Returns:
        the model, its positions (x, y, yaw, arm) or (arm), and which joints follow which.

    Raises:
        ModelError: a frame of the configuration does not exist, or one does twice.
    """
    arm, mimics = build_arm(config, description or read_urdf(config.arm.description))
    if config.arm.mount.parent != "base":
        raise ModelError(f"robot {config.name}: arm.mount.parent: only 'base' is there")
    if config.base is None:
        carrier = build_mounting(mounting or pin.SE3.Identity())
        ground = "mounting"
    else:
        carrier, ground = build_base(config.base), "base"
    taken = {ground, TOOL, *BASE_JOINTS[: carrier.nv]}
    for frame in arm.frames:
        if (
            frame.name.removesuffix(_LINK) in taken
        ):  # the URDF of the UR10 has a base; ours is the platform's
            frame.name = f"arm_{frame.name}"
    place = placement(config.arm.mount)
    root = _of_root(config, arm)
    place = place if root is None else place * root.inverse()
    model = pin.appendModel(carrier, arm, carrier.getFrameId(ground), place)
    for frame in model.frames:
        frame.name = frame.name.removesuffix(_LINK)
    # appendModel drops the armature of both, so it is set on the whole.
    armature = dict(zip(config.arm.joints, config.arm.armature, strict=True))
    model.armature = np.array([armature.get(name, 0.0) for name in model.names[1:]])
    for name, frame in {TOOL: config.tool, **config.tools}.items():
        key = f"tools.{name}" if name in config.tools else TOOL
        _add_frame(model, name, frame, f"robot {config.name}: {key}")
    return model, mimics


def _of_root(config: RobotConfig, arm: pin.Model) -> pin.SE3 | None:
    """Return where the link that is mounted is in the frame of the URDF's first; None: it is it."""
    root = config.arm.root
    index = _index(arm, root)
    if index is None:
        raise ModelError(f"robot {config.name}: arm.root: no link {shown(root)}")
    frame = arm.frames[index]
    if frame.parentJoint != 0:
        raise ModelError(f"robot {config.name}: arm.root: link {shown(root)} moves with a joint")
    return None if index <= 1 else frame.placement


def frame_index(model: pin.Model, name: str) -> int | None:
    """Return the place of a frame in a model, a link's before a joint's; None: it is not there."""
    for kind in (pin.BODY, pin.OP_FRAME, pin.FIXED_JOINT, pin.JOINT, pin.SENSOR):
        if model.existFrame(name, kind):
            return int(model.getFrameId(name, kind))
    return None


def _index(model: pin.Model, name: str) -> int | None:
    """Return the place of a frame that may have had to give up its name."""
    found = (frame_index(model, each) for each in (f"{name}{_LINK}", name, f"arm_{name}"))
    return next((index for index in found if index is not None), None)


def _add_frame(model: pin.Model, name: str, config: FrameConfig, where: str) -> None:
    """Add a configured frame; raises ModelError without its parent, or where its name is taken."""
    parent = _index(model, config.parent)
    if parent is None:
        raise ModelError(f"{where}.parent: no link {config.parent!r}")
    if frame_index(model, name) is not None:
        raise ModelError(f"{where}: the robot has a frame {name!r} already")
    frame = model.frames[parent]
    model.addFrame(
        pin.Frame(
            name,
            frame.parentJoint,
            parent,
            frame.placement * placement(config),
            pin.FrameType.OP_FRAME,
        )
    )
