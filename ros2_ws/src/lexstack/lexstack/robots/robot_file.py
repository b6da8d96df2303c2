"""What a robot's file says, and the rest of it: from the URDF, else from the defaults stated here.

Most of a file may be left out. A value per joint is a number for all joints, a list in the order of
``joints``, or a mapping by joint, which leaves the default to the joints that it does not name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from lexstack.errors import ConfigurationError, ModelError
from lexstack.options import Range, build, shown
from lexstack.robots.description import located
from lexstack.robots.joint_inertia import BANDWIDTH, DAMPING_RATIO, joint_inertias
from lexstack.robots.options import AnyBase, ArmConfig, FrameConfig, RobotConfig, SphereConfig
from lexstack.robots.per_joint import (
    NotNegativePerJoint,
    PerJoint,
    PositivePerJoint,
    number,
    per_joint,
    zero,
)
from lexstack.robots.urdf import Description, read_urdf, slides

RISE = 0.4  # s, in which a joint reaches its full velocity: the default of its acceleration
RAMP = 0.01  # s, in which a joint reaches its full acceleration: the default of its jerk

# Defaults of the joints' torque loop, which the simulation alone needs: of a joint that turns, and
# of one that slides. Stiffness and damping follow from what the joint moves.
_LOOP = {
    "torque_rate": (1000.0, 10000.0),  # N m/s, N/s
    "armature": (0.1, 1.0),  # kg m2, kg
    "q_star_distance": (0.1, 0.02),  # rad, m
}


@dataclass(frozen=True, slots=True)
class ArmFile:
    """The section ``arm`` of a robot's file; the units are those of ``ArmConfig``."""

    description: str  # a URDF: path, package://NAME/..., or below example-robot-data's robots
    packages: tuple[str, ...] = ()  # folders of packages, for package:// where no ament index is
    root: str | None = None  # default: the URDF's first link
    mount: FrameConfig = field(default_factory=lambda: FrameConfig("base"))  # parent: base
    joints: tuple[str, ...] | None = None  # default: all that move, but fixed and mimicking ones
    fixed: dict[str, float] = field(default_factory=dict)  # default: 0, or the limit next to it
    home: PerJoint = field(default_factory=dict)  # default: 0, or mid-range where 0 is outside
    position_lower: PerJoint = field(default_factory=dict)  # default: the URDF's
    position_upper: PerJoint = field(default_factory=dict)  # default: the URDF's
    velocity: PositivePerJoint = field(default_factory=dict)  # default: the URDF's
    acceleration: PositivePerJoint = field(default_factory=dict)  # default: velocity / 0.4 s
    jerk: PositivePerJoint = field(default_factory=dict)  # default: acceleration / 0.01 s
    torque: PositivePerJoint = field(default_factory=dict)  # default: the URDF's effort
    torque_rate: PositivePerJoint = field(default_factory=dict)  # default: 1000 N m/s, 10000 N/s
    stiffness: PositivePerJoint = field(
        default_factory=dict
    )  # default: m (30 rad/s)^2, m: joint_inertias
    damping: NotNegativePerJoint = field(default_factory=dict)  # default: 2 sqrt(stiffness m)
    armature: NotNegativePerJoint = field(default_factory=dict)  # default: 0.1 kg m2, 1 kg
    q_star_distance: PositivePerJoint = field(default_factory=dict)  # default: 0.1 rad, 0.02 m
    posture: PerJoint | None = None  # where the task posture leads; default: mid-range


@dataclass(frozen=True, slots=True)
class RobotFile:
    """A robot's file: what it leaves out, ``completed`` fills in."""

    name: str  # of its file
    arm: ArmFile  # what moves but the base
    base: AnyBase | None = None  # null: it does not drive
    tool: FrameConfig | None = None  # default: the only link that carries no other
    tools: dict[str, FrameConfig] = field(default_factory=dict)  # other end effectors, by name
    spheres: tuple[SphereConfig, ...] = ()  # that stand for it where distances are kept


def completed(
    file: RobotFile,
    where: str,
    folder: Path | None = None,
    description: Description | None = None,
) -> RobotConfig:
    """Return a robot's configuration with every value in it.

    Args:
        file: what is known of it.
        where: its origin, for errors.
        folder: that relative paths in it begin at.
        description: in place of the URDF that it names.

    Raises:
        ConfigurationError: a value is missing or wrong; the text names key and joint.
    """
    try:
        place = located(file.arm.description, folder, file.arm.packages) if not description else ""
        urdf = description or read_urdf(place)
    except ModelError as error:
        raise ConfigurationError(f"{where}: arm.description: {error}") from error
    arm = _arm(file.arm, place, urdf, f"{where}: arm")
    here = folder or Path()
    packages = tuple(str((here / each).resolve()) for each in file.arm.packages)
    arm = build(ArmConfig, replace(arm, packages=packages), f"{where}: arm")
    tool = file.tool or FrameConfig(_leaf(urdf, arm.joints, f"{where}: tool"))
    return RobotConfig(file.name, file.base, arm, tool, file.spheres, file.tools)


def _arm(arm: ArmFile, place: str, urdf: Description, where: str) -> ArmConfig:
    """Return the section ``arm`` with every value in it; the ranges are checked later."""
    model = urdf.model
    joints = _joints(arm, urdf, where)
    index = {name: model.joints[model.getJointId(name)].idx_v for name in model.names[1:]}
    sliding = {name: slides(model, model.getJointId(name)) for name in model.names[1:]}

    def values(key: str, default: Callable[[str], float]) -> tuple[float, ...]:
        return per_joint(getattr(arm, key), joints, default, f"{where}: {key}")

    def of_urdf(key: str, limits: Sequence[float]) -> tuple[float, ...]:
        found = values(key, lambda name: number(limits[index[name]]))
        for name, value in zip(joints, found, strict=True):
            Range(0.0, open=True).check(value, f"{where}: {name}: {key}")
        return found

    lower = values("position_lower", lambda name: number(model.lowerPositionLimit[index[name]]))
    upper = values("position_upper", lambda name: number(model.upperPositionLimit[index[name]]))
    for name, least, most in zip(joints, lower, upper, strict=True):
        if name not in urdf.continuous and not (math.isfinite(least) and math.isfinite(most)):
            raise ConfigurationError(f"{where}: {name}: position_lower and _upper must be finite")
    range_of = dict(zip(joints, zip(lower, upper, strict=True), strict=True))
    velocity = dict(zip(joints, of_urdf("velocity", model.velocityLimit), strict=True))
    acceleration = values("acceleration", lambda name: velocity[name] / RISE)
    rise = dict(zip(joints, acceleration, strict=True))
    loop = {
        key: values(key, lambda name, pair=pair: pair[sliding[name]])  # type: ignore[misc]
        for key, pair in _LOOP.items()
    }
    home = values("home", lambda name: zero(*range_of[name]))
    resting = dict(zip(joints, home, strict=True))
    fixed = _fixed(arm, joints, urdf, where)
    armature = dict(zip(joints, loop["armature"], strict=True))
    moved = joint_inertias(urdf, resting, fixed, armature)
    stiffness = values("stiffness", lambda name: moved[name] * BANDWIDTH**2)
    spring = dict(zip(joints, stiffness, strict=True))
    posture = None
    if arm.posture is not None:
        posture = per_joint(arm.posture, joints, resting.__getitem__, f"{where}: posture")
    return ArmConfig(
        description=place,
        root=model.frames[min(1, model.nframes - 1)].name if arm.root is None else arm.root,
        mount=arm.mount,
        joints=joints,
        fixed=fixed,
        home=home,
        position_lower=lower,
        position_upper=upper,
        velocity=tuple(velocity.values()),
        acceleration=acceleration,
        jerk=values("jerk", lambda name: rise[name] / RAMP),
        torque=of_urdf("torque", model.effortLimit),
        posture=posture,
        stiffness=stiffness,
        damping=values(
            "damping", lambda name: 2.0 * DAMPING_RATIO * math.sqrt(spring[name] * moved[name])
        ),
        torque_rate=loop["torque_rate"],
        armature=loop["armature"],
        q_star_distance=loop["q_star_distance"],
    )


def _joints(arm: ArmFile, urdf: Description, where: str) -> tuple[str, ...]:
    """Return the controlled joints; raises ConfigurationError for one that cannot be."""
    known = tuple(urdf.model.names[1:])
    for key, names in (("joints", arm.joints or ()), ("fixed", arm.fixed)):
        for name in names:
            if name not in known:
                listed = ", ".join(known)
                raise ConfigurationError(
                    f"{where}: {key}: no joint {shown(name)}; known: {shown(listed)[1:-1]}"
                )
    if arm.joints is None:
        found = tuple(name for name in known if name not in arm.fixed and name not in urdf.mimics)
        if not found:
            raise ConfigurationError(f"{where}: joints: no joint of the URDF moves")
        return found
    for i, name in enumerate(arm.joints):
        if name in arm.joints[:i] or name in arm.fixed:
            raise ConfigurationError(f"{where}: joints: {name!r} stands twice, or in 'fixed' too")
        if name in urdf.mimics:
            followed = urdf.mimics[name].joint
            raise ConfigurationError(f"{where}: joints: {name!r} mimics {followed!r}")
    if not arm.joints:
        raise ConfigurationError(f"{where}: joints: at least one joint is needed")
    return arm.joints


def _fixed(
    arm: ArmFile, joints: tuple[str, ...], urdf: Description, where: str
) -> dict[str, float]:
    """Return where every joint that is neither controlled nor follows another is held."""
    model, fixed = urdf.model, dict(arm.fixed)
    for name, value in fixed.items():
        if not math.isfinite(value):
            raise ConfigurationError(f"{where}: fixed.{name}: must be finite, got {value}")
    for name in model.names[1:]:
        if name not in joints and name not in fixed and name not in urdf.mimics:
            i = model.joints[model.getJointId(name)].idx_v
            lower, upper = model.lowerPositionLimit[i], model.upperPositionLimit[i]
            fixed[name] = float(min(max(0.0, lower), upper)) if lower <= upper else 0.0
    return fixed


def _leaf(urdf: Description, joints: tuple[str, ...], where: str) -> str:
    """Return the last link of the only chain of controlled joints."""
    model = urdf.model
    ids = [model.getJointId(name) for name in joints]
    ends = [i for i in ids if not any(i in list(model.supports[j])[:-1] for j in ids)]
    if len(ends) == 1:
        for frame in reversed(list(model.frames)):
            if (
                frame.name
                and ends[0] in model.supports[frame.parentJoint]
                and frame.type.name == "BODY"
            ):
                return str(frame.name)
    names = ", ".join(model.names[i] for i in ends)
    raise ConfigurationError(f"{where}: is missing; joints that end a chain: {names}")
