"""What can touch: each robot the others, and an arm its own platform and shoulder."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pinocchio as pin

from lexstack_core.model import RobotModel
from lexstack_sim.meshes import arm_shapes

APART = 4
"""Links so many joints apart along the chain can touch each other; nearer ones cannot."""

GROUP = 3
"""MuJoCo's group of contact geometry: hidden from the camera."""


def add_contacts(
    spec: mujoco.MjSpec, robot: RobotModel, bodies: dict[int, mujoco.MjsBody], index: int
) -> dict[int, list[str]]:
    """Add a robot's contact geometry: a box for its chassis, convex hulls for its arm.

    Robot ``index`` has a bit of its own, and collides with every other bit: never with itself
    nor with the floor, since planar joints carry the load.

    Returns:
        names of the geoms by pinocchio joint.
    """
    bit = 1 << index
    mask = {"contype": bit, "conaffinity": 0x7FFFFFFF & ~bit, "group": GROUP}
    base = robot.config.base
    joint = robot.pinocchio.frames[robot.pinocchio.getFrameId("base")].parentJoint
    chassis = bodies[joint].add_geom(
        name=f"{robot.name}/contact/chassis",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[0.5 * side for side in base.chassis_size],
        pos=(0.0, 0.0, base.chassis_height),
        **mask,
    )
    geoms: dict[int, list[str]] = {joint: [chassis.name]}
    for shape in arm_shapes(robot, pin.GeometryType.COLLISION):
        name = f"{robot.name}/contact/{shape.name}"
        body = bodies[shape.joint]
        if shape.is_box:
            shape.add_box(body, name=name, **mask)
        else:
            asset = f"contact/{robot.config.name}/{shape.name}"
            shape.add_mesh(spec, body, asset, shape.mesh(), name=name, **mask)
        geoms.setdefault(shape.joint, []).append(name)
    return geoms


def add_self_contacts(spec: mujoco.MjSpec, geoms: dict[int, list[str]]) -> None:
    """Add the pairs within one robot that can touch: links at least APART joints apart."""
    for (i, first), (j, second) in itertools.combinations(geoms.items(), 2):
        if abs(i - j) >= APART:
            for one, other in itertools.product(first, second):
                spec.add_pair(name=f"{one}:{other}", geomname1=one, geomname2=other)


def touching(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[int, float]:
    """Return at how many points robots touch others or obstacles, and the sum of forces [N]."""
    if data.ncon == 0:
        return 0, 0.0
    roots = model.body_rootid[model.geom_bodyid[data.contact.geom]]
    apart = np.flatnonzero(roots[:, 0] != roots[:, 1])
    force, total = np.zeros(6), 0.0
    for contact in apart:
        mujoco.mj_contactForce(model, data, int(contact), force)
        total += float(force[0])
    return len(apart), total
