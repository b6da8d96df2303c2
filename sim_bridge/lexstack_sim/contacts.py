"""What can touch: each robot the others, and an arm its own platform and shoulder."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.robots import RobotModel, Team
from lexstack_sim.coordinates import Coordinates
from lexstack_sim.meshes import arm_shapes

APART = 4
"""Links so many joints apart along the tree can touch each other; nearer ones cannot."""

TOUCHING = 0.001
"""Parts of one robot that are nearer than this at its home [m] never touch in the simulation."""

GROUP = 3
"""MuJoCo's group of contact geometry: hidden from the camera."""

OBSTACLE = 1 << 30
"""The bit of contact that obstacles have; the robots have those below."""

_DIGITS = 15  # binary digits of a robot's number, two bits of contact for each: 30 in all


def add_contacts(
    spec: mujoco.MjSpec, robot: RobotModel, bodies: dict[int, mujoco.MjsBody], index: int
) -> dict[int, list[str]]:
    """Add a robot's contact geometry: its chassis as a box, its URDF's shapes, hulls of meshes.

    Robot ``index`` collides with every other robot and with obstacles: never with itself nor with
    the floor, since planar joints carry the load.

    Returns:
        names of the geoms by pinocchio joint.

    Raises:
        ModelError: there are more robots than the masks of contact can tell apart.
    """
    contype, conaffinity = robot_masks(index)
    mask = {"contype": contype, "conaffinity": conaffinity | OBSTACLE, "group": GROUP}
    geoms: dict[int, list[str]] = {}
    base = robot.config.base
    if base is not None and base.chassis_mass:
        joint = robot.pinocchio.frames[robot.pinocchio.getFrameId("base")].parentJoint
        chassis = bodies[joint].add_geom(
            name=f"{robot.name}/contact/chassis",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.5 * side for side in base.chassis_size],
            pos=(0.0, 0.0, base.chassis_height),
            **mask,
        )
        geoms[joint] = [chassis.name]
    for shape in arm_shapes(robot, pin.GeometryType.COLLISION):
        name = f"{robot.name}/contact/{shape.name}"
        body = bodies[shape.joint]
        if shape.is_primitive:
            shape.add_primitive(body, name=name, **mask)
        else:
            asset = f"contact/{robot.config.name}/{shape.name}"
            shape.add_mesh(spec, body, asset, shape.mesh(), name=name, **mask)
        geoms.setdefault(shape.joint, []).append(name)
    return geoms


def robot_masks(index: int) -> tuple[int, int]:
    """Return contype and conaffinity of a robot among robots, without the bit of obstacles.

    MuJoCo lets two geoms touch where contype of one and conaffinity of the other have a bit in
    common. Each binary digit of the robot's number has two bits, one for 0 and one for 1: contype
    has those of the robot's own digits, conaffinity those of the opposite ones. So two robots touch
    exactly if their numbers differ in a digit. (With one bit for each robot there would be 30.)

    Raises:
        ModelError: the number has too many digits.
    """
    if index >= 1 << _DIGITS:
        raise ModelError(f"robots: contacts of at most {1 << _DIGITS} can be told apart")
    digits = [(index >> place) & 1 for place in range(_DIGITS)]
    contype = sum(1 << (2 * place + digit) for place, digit in enumerate(digits))
    conaffinity = sum(1 << (2 * place + 1 - digit) for place, digit in enumerate(digits))
    return contype, conaffinity


def add_self_contacts(spec: mujoco.MjSpec, robot: RobotModel, geoms: dict[int, list[str]]) -> None:
    """Add the pairs within one robot that can touch: links at least APART joints apart."""
    for (i, first), (j, second) in itertools.combinations(geoms.items(), 2):
        if joints_between(robot.pinocchio, i, j) >= APART:
            for one, other in itertools.product(first, second):
                spec.add_pair(name=f"{one}:{other}", geomname1=one, geomname2=other)


def joints_between(model: pin.Model, one: int, other: int) -> int:
    """Return how many joints lie between the bodies of two joints, along the tree."""
    ways = [set(model.supports[joint]) for joint in (one, other)]
    return len(ways[0] ^ ways[1])


def compiled(spec: mujoco.MjSpec, team: Team) -> mujoco.MjModel:
    """Return the model of a world, without pairs of one robot that touch at its home.

    Contact geometry is convex: the hull of a torso holds the shoulders that are in its recesses.
    """
    model = spec.compile()
    if not model.npair:
        return model
    data = mujoco.MjData(model)
    Coordinates(model, team).put(data, team.home())
    mujoco.mj_kinematics(model, data)
    closed = [
        model.pair(i).name
        for i in range(model.npair)
        if mujoco.mj_geomDistance(
            model, data, model.pair_geom1[i], model.pair_geom2[i], TOUCHING, None
        )
        < TOUCHING
    ]
    if not closed:
        return model
    for name in closed:
        spec.delete(spec.pair(name))
    return spec.compile()


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
