"""One URDF per robot: planar base joints, platform and arm, for tools that show robots."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

import pinocchio as pin

from lexstack.robots import BASE_JOINTS, AnyBase, RobotModel, along_axes, build_base, urdf_text
from lexstack_sim.meshes import link_in_model

_PLANAR = (("x", "prismatic", "1 0 0"), ("y", "prismatic", "0 1 0"), ("yaw", "continuous", "0 0 1"))


def robot_urdf(robot: RobotModel) -> str:
    """Return the URDF of a robot as it stands in the frame ``world``.

    Its joints bear the names of the entries of the robot's q. Links of the robot's own URDF keep
    their names, but for those of ``world``, the platform and the tools: they begin with ``arm_``
    then.
    """
    root = ET.Element("robot", name=robot.name)
    ET.SubElement(root, "link", name="world")
    base = robot.config.base
    if base is not None:
        _add_base(root, base)
    own = {link.get("name", "") for link in root.iter("link")} | {"tool", *robot.config.tools}
    arm = robot.config.arm
    if arm.description:
        source = ET.fromstring(urdf_text(arm.description))  # noqa: S314 - the robot came from it
        renamed = _rename_links(source, own)
        first = _first(source, renamed)
        ground = "world" if base is None else "base"
        mount = _joint(root, "arm_mount", "fixed", ground, renamed[first])
        _origin(mount, *_mounting(robot, first))
        root.extend(
            each
            for element in source
            if element.tag in ("link", "joint")
            for each in _plain(element, robot, own | set(renamed.values()))
        )
        for name, frame in {"tool": robot.config.tool, **robot.config.tools}.items():
            ET.SubElement(root, "link", name=name)
            tool = _joint(
                root, f"{name}_mount", "fixed", renamed.get(frame.parent, frame.parent), name
            )
            _origin(tool, frame.xyz, frame.rpy)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=True)


def _add_base(root: ET.Element, base: AnyBase) -> None:
    """Add the joints and links of a platform."""
    links = ("world", "base_x_link", "base_y_link", "base")
    for link in links[1:-1]:
        ET.SubElement(root, "link", name=link)
    for i, (joint, (_, kind, axis)) in enumerate(zip(BASE_JOINTS, _PLANAR, strict=True)):
        element = _joint(root, joint, kind, links[i], links[i + 1])
        ET.SubElement(element, "axis", xyz=axis)
        limit = {
            "effort": str(along_axes(base.servo_force)[i]),
            "velocity": str(along_axes(base.velocity)[i]),
        }
        if kind == "prismatic":
            limit |= {"lower": "-1000", "upper": "1000"}
        ET.SubElement(element, "limit", limit)
    _add_platform(root, base)


def _rename_links(source: ET.Element, taken: set[str]) -> dict[str, str]:
    """Rename the links of a URDF whose names are taken; return the new name of every link."""
    names = [link.get("name", "") for link in source.findall("link")]
    renamed = {name: f"arm_{name}" if name in taken else name for name in names}
    for link in source.findall("link"):
        link.set("name", renamed[link.get("name", "")])
    for joint in source.findall("joint"):
        for end in joint.iter():
            if end.tag in ("parent", "child"):
                end.set("link", renamed[end.get("link", "")])
    return renamed


def _first(source: ET.Element, renamed: dict[str, str]) -> str:
    """Return the own name of a URDF's first link, which hangs on no joint."""
    hanging = {child.get("link") for child in source.iter("child")}
    return next(name for name, now in renamed.items() if now not in hanging)


def _mounting(robot: RobotModel, first: str) -> tuple[Iterable[float], Iterable[float]]:
    """Return xyz and rpy of the URDF's first link on what it is mounted on."""
    arm = robot.config.arm
    if robot.has_base and first == arm.root:
        return arm.mount.xyz, arm.mount.rpy
    place = robot.pinocchio.frames[robot.frame(link_in_model(robot, first))].placement
    return place.translation, pin.rpy.matrixToRpy(place.rotation)


def _plain(element: ET.Element, robot: RobotModel, taken: set[str]) -> list[ET.Element]:
    """Return an element of a URDF, a planar joint as three joints with links between them.

    Args:
        element: a link or joint.
        robot: whose limits of velocity and torque they have.
        taken: names of links that there are.
    """
    name, parent, child = element.get("name", ""), element.find("parent"), element.find("child")
    planar = element.tag == "joint" and element.get("type") == "planar"
    if not planar or parent is None or child is None:
        return [element]
    between = [_free(f"{name}_{axis}_link", taken) for axis in ("x", "y")]
    links = (parent.get("link", ""), *between, child.get("link", ""))
    found: list[ET.Element] = [ET.Element("link", name=link) for link in between]
    for i, (axis, kind, direction) in enumerate(_PLANAR):
        joint = ET.Element("joint", name=f"{name}_{axis}", type=kind)
        ET.SubElement(joint, "parent", link=links[i])
        ET.SubElement(joint, "child", link=links[i + 1])
        ET.SubElement(joint, "axis", xyz=direction)
        ET.SubElement(joint, "limit", _limit(robot, f"{name}_{axis}", slides=kind == "prismatic"))
        origin = element.find("origin")
        if origin is not None and i == 0:
            joint.append(origin)
        found.append(joint)
    return found


def _free(name: str, taken: set[str]) -> str:
    """Return a name that no link has, and take it."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def _limit(robot: RobotModel, joint: str, *, slides: bool) -> dict[str, str]:
    """Return the limits of one of the joints that make a planar one; it ends nowhere near."""
    ends = {"lower": "-1000", "upper": "1000"} if slides else {}
    if joint not in robot.joints:  # held where it is
        return {"effort": "0", "velocity": "0", **ends}
    arm = robot.config.arm
    place = arm.joints.index(joint)
    return {"effort": str(arm.torque[place]), "velocity": str(arm.velocity[place]), **ends}


def _add_platform(root: ET.Element, base: AnyBase) -> None:
    """Add the link ``base``: a box on four cylinders, with the inertia of the model's platform.

    An empty one where the robot's own URDF has the platform.
    """
    link = ET.SubElement(root, "link", name="base")
    if not base.chassis_mass:
        return
    wheels = base.wheels
    platform = build_base(base).inertias[len(BASE_JOINTS)]
    inertial = ET.SubElement(link, "inertial")
    _origin(inertial, platform.lever)
    ET.SubElement(inertial, "mass", value=repr(float(platform.mass)))
    tensor = {
        f"i{'xyz'[i]}{'xyz'[j]}": repr(float(platform.inertia[i, j]))
        for i in range(3)
        for j in range(i, 3)
    }
    ET.SubElement(inertial, "inertia", tensor)
    for kind in ("visual", "collision"):
        chassis = ET.SubElement(link, kind)
        _origin(chassis, (0.0, 0.0, base.chassis_height))
        geometry = ET.SubElement(chassis, "geometry")
        ET.SubElement(geometry, "box", size=_text(base.chassis_size))
    for x in (wheels.x, -wheels.x):
        for y in (wheels.y, -wheels.y):
            wheel = ET.SubElement(link, "visual")
            _origin(wheel, (x, y, wheels.radius), (1.5707963267948966, 0.0, 0.0))
            geometry = ET.SubElement(wheel, "geometry")
            size = {"radius": str(wheels.radius), "length": str(wheels.width)}
            ET.SubElement(geometry, "cylinder", size)


def _joint(root: ET.Element, name: str, kind: str, parent: str, child: str) -> ET.Element:
    """Add a joint between two links."""
    joint = ET.SubElement(root, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    return joint


def _origin(
    element: ET.Element, xyz: Iterable[float], rpy: Iterable[float] = (0.0, 0.0, 0.0)
) -> None:
    """Place an element in its parent."""
    ET.SubElement(element, "origin", xyz=_text(xyz), rpy=_text(rpy))


def _text(values: Iterable[float]) -> str:
    """Return numbers as URDF has them, without loss."""
    return " ".join(repr(float(value)) for value in values)
