"""A URDF as a pinocchio model in which every joint has one coordinate, and who mimics whom."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.options import shown
from lexstack.robots.description import is_text, urdf_text
from lexstack.robots.mimics import Mimic, numbers, read_mimics
from lexstack.types import Vector

_TYPES = ("revolute", "continuous", "prismatic", "planar", "fixed")
_PLANAR = (
    ("x", pin.JointModelPX),
    ("y", pin.JointModelPY),
    ("yaw", pin.JointModelRZ),
)
_PER_VELOCITY = (
    *("lowerVelocityLimit", "upperVelocityLimit", "lowerEffortLimit", "upperEffortLimit"),
    *("lowerDryFrictionLimit", "upperDryFrictionLimit", "damping"),
)


@dataclass(frozen=True, slots=True, eq=False)
class Description:
    """What a URDF says of the kinematics.

    Attributes:
        model: every joint with one position and one velocity, mimicking ones too. A continuous
            joint turns without limits, its position is the unwrapped angle. A planar joint P is
            the joints P_x, P_y and P_yaw.
        mimics: the joints that follow others, by name.
        continuous: names of the joints that have no position limits.
    """

    model: pin.Model
    mimics: Mapping[str, Mimic]
    continuous: frozenset[str]


def read_urdf(description: str) -> Description:
    """Return what a URDF says; ``description``: as ``located`` returned it.

    Meshes are not read. A planar joint moves in its x-y plane, as in pinocchio and MoveIt.

    Raises:
        ModelError: it cannot be read, is no URDF, or has a joint of another kind.
    """
    where = "the URDF" if is_text(description) else Path(description).name
    text = urdf_text(description)
    tree = _tree(text, where)
    mimics = read_mimics(tree, where)
    if tree.find("link/*/geometry/capsule") is not None:  # which pinocchio's parser complains of
        text = _without_shapes(tree)
    try:
        full = pin.buildModelFromXML(text)
    except Exception as error:  # pinocchio raises what urdfdom and Boost do
        reason = " ".join(str(error).split())
        raise ModelError(f"{where}: pinocchio cannot read it: {reason}") from error
    model, continuous = one_coordinate(full, where)
    return Description(model, mimics, continuous)


def _without_shapes(tree: ET.Element) -> str:
    """Return a URDF without visual and collision geometry."""
    for link in tree.findall("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    return ET.tostring(tree, encoding="unicode")


def one_coordinate(full: pin.Model, where: str) -> tuple[pin.Model, frozenset[str]]:
    """Return a model with one coordinate per joint, and which joints turn without limits.

    Raises:
        ModelError: a joint is neither revolute, continuous, prismatic nor planar.
    """
    free = frozenset(
        full.names[i] for i in range(1, full.njoints) if "RevoluteUnbounded" in _kind(full, i)
    )
    if all(joint.nq == joint.nv == 1 and _known(joint) for joint in full.joints[1:]):
        return full, free
    model, places = pin.Model(), [0]
    model.name, model.gravity = full.name, full.gravity
    for i in range(1, full.njoints):
        places.append(_add(model, full, i, places[full.parents[i]], where))
    model.inertias[0] = full.inertias[0]
    for frame in list(full.frames)[1:]:
        # With its inertia: that of links which do not move goes from there to what carries them.
        joint = places[frame.parentJoint]
        copy = (frame.name, joint, frame.parentFrame, frame.placement, frame.type, frame.inertia)
        model.addFrame(pin.Frame(*copy), False)
    return model, free | frozenset(
        f"{full.names[i]}_{axis}"
        for i in range(1, full.njoints)
        if _kind(full, i) == "Planar"
        for axis, _ in _PLANAR
    )


def slides(model: pin.Model, joint: int) -> bool:
    """Return whether a joint of one coordinate slides: its position is in m, else in rad."""
    kind = _kind(model, joint)
    return kind in ("PX", "PY", "PZ") or "Prismatic" in kind


def _kind(model: pin.Model, joint: int) -> str:
    """Return pinocchio's name of a joint's type; RUBX and its like as their unaligned form."""
    name = str(model.joints[joint].shortname()).removeprefix("JointModel")
    return "RevoluteUnbounded" if name.startswith("RUB") else name


def _known(joint: pin.JointModel) -> bool:
    """Return whether a joint turns or slides about one axis of its own."""
    name = joint.shortname().removeprefix("JointModel")
    return name in ("RX", "RY", "RZ", "PX", "PY", "PZ", "RevoluteUnaligned", "PrismaticUnaligned")


def _add(model: pin.Model, full: pin.Model, joint: int, parent: int, where: str) -> int:
    """Add one joint of ``full``, with its body and limits; return where it now is."""
    kind, name = _kind(full, joint), full.names[joint]
    place = full.jointPlacements[joint]
    if kind == "Planar":
        for axis, make in _PLANAR:
            parent = model.addJoint(parent, make(), place, f"{name}_{axis}")
            place = pin.SE3.Identity()
            _copy_limits(model, parent, full, joint, unlimited=True)
    elif "RevoluteUnbounded" in kind:
        parent = model.addJoint(parent, _turning(full, joint), place, name)
        _copy_limits(model, parent, full, joint, unlimited=True)
    elif _known(full.joints[joint]):
        parent = model.addJoint(parent, full.joints[joint], place, name)
        _copy_limits(model, parent, full, joint, unlimited=False)
    else:
        raise ModelError(
            f"{where}: joint {shown(name)}: of type {kind}; known: {', '.join(_TYPES)} and mimic"
        )
    model.appendBodyToJoint(parent, full.inertias[joint], pin.SE3.Identity())
    return parent


def _copy_limits(
    model: pin.Model, joint: int, full: pin.Model, origin: int, *, unlimited: bool
) -> None:
    """Give a new joint of one coordinate the limits of the joint that it was."""
    i, source = model.joints[joint].idx_v, full.joints[origin]
    for name in _PER_VELOCITY:
        getattr(model, name)[i] = getattr(full, name)[source.idx_v]
    model.lowerPositionLimit[i] = -math.inf if unlimited else full.lowerPositionLimit[source.idx_q]
    model.upperPositionLimit[i] = math.inf if unlimited else full.upperPositionLimit[source.idx_q]


def _turning(full: pin.Model, joint: int) -> pin.JointModel:
    """Return a revolute joint about the axis of a continuous one."""
    alone = pin.Model()  # the axis cannot be read; of the whole model the data would cost 0.2 s
    alone.addJoint(0, full.joints[joint], pin.SE3.Identity(), full.names[joint])
    axis: Vector = pin.computeJointJacobians(alone, alone.createData(), pin.neutral(alone))[3:]
    aligned = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)
    for i, make in enumerate(aligned):
        if (axis == np.eye(3)[i]).all():
            return make()
    return pin.JointModelRevoluteUnaligned(axis.copy())


def _tree(text: str, where: str) -> ET.Element:
    """Return a URDF's XML; raises ModelError for what is none, before pinocchio's parser prints."""
    if "<!ENTITY" in text:
        raise ModelError(f"{where}: entities are not supported")  # a few lines can stand for GB
    try:
        tree = ET.fromstring(text)  # noqa: S314 - has no entities
    except (ET.ParseError, ValueError) as error:
        raise ModelError(f"{where}: not valid XML: {error}") from error
    if tree.tag != "robot" or not tree.get("name"):
        raise ModelError(f"{where}: expected a <robot> with a name, got <{tree.tag}> without")
    for joint in tree.findall("joint"):
        name, kind = joint.get("name"), joint.get("type")
        if kind not in _TYPES:
            known = ", ".join(_TYPES)
            raise ModelError(f"{where}: joint {name!r}: of type {kind}; known: {known} and mimic")
        limit = joint.find("limit")
        for key, value in ({} if limit is None else limit.attrib).items():
            if not all(map(math.isfinite, numbers(value) or (math.nan,))):
                raise ModelError(f"{where}: joint {name!r}: limit: {key}: got {shown(value)}")
        axis = joint.find("axis")
        if kind == "planar" and axis is not None and numbers(axis.get("xyz"))[:2] != (0.0, 0.0):
            raise ModelError(f"{where}: joint {name!r}: planar, but not in the plane of x and y")
    return tree
