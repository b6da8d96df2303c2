"""One URDF per robot: planar base joints, platform and arm, for tools that show robots."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

from lexstack.robots import BASE_JOINTS, RobotModel, build_base, description_path


def robot_urdf(robot: RobotModel) -> str:
    """Return the URDF of a robot; its joints bear the names of the robot's part of chi."""
    base, arm = robot.config.base, robot.config.arm
    root = ET.Element("robot", name=robot.name)
    links = ("world", "base_x_link", "base_y_link", "base")
    for link in links[:-1]:
        ET.SubElement(root, "link", name=link)
    for i, joint in enumerate(BASE_JOINTS):
        kind = "continuous" if joint == "base_yaw" else "prismatic"
        element = _joint(root, joint, kind, links[i], links[i + 1])
        ET.SubElement(element, "axis", xyz=("1 0 0", "0 1 0", "0 0 1")[i])
        limit = {"effort": str(base.servo_force[i]), "velocity": str(base.velocity[i])}
        if kind == "prismatic":
            limit |= {"lower": "-1000", "upper": "1000"}
        ET.SubElement(element, "limit", limit)
    _add_platform(root, robot)
    mount = _joint(root, "arm_mount", "fixed", "base", arm.root)
    _origin(mount, arm.mount.xyz, arm.mount.rpy)
    source = ET.parse(description_path(arm.description)).getroot()  # noqa: S314 - as above
    root.extend(element for element in source if element.tag in ("link", "joint"))
    ET.SubElement(root, "link", name="tool")
    tool = _joint(root, "tool_mount", "fixed", robot.config.tool.parent, "tool")
    _origin(tool, robot.config.tool.xyz, robot.config.tool.rpy)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode", xml_declaration=True)


def _add_platform(root: ET.Element, robot: RobotModel) -> None:
    """Add the link ``base``: a box on four cylinders, with the inertia of the model's platform."""
    base, wheels = robot.config.base, robot.config.base.wheels
    link = ET.SubElement(root, "link", name="base")
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
