"""Spheres for a robot, fitted to the shapes that touch: its URDF's and its chassis."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import mujoco
import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.robots import Covering, RobotModel, cover
from lexstack.types import Matrix
from lexstack_sim.meshes import Shape, arm_shapes, is_flat, link_in_model, primitive
from lexstack_sim.primitives import triangles

_ROUND = 1.02  # by which the corners that stand for something round are moved outwards
_THICK = 1e-3  # m, of a flat mesh, which touches as a thin box


@dataclass(frozen=True, slots=True)
class LinkSpheres:
    """The spheres of one link, in its frame."""

    link: str
    covering: Covering


def shapes_by_link(robot: RobotModel) -> dict[str, list[Matrix]]:
    """Return the corners of what touches, by the link that carries it, shape (m, 3) each [m]."""
    shapes: dict[str, list[Matrix]] = defaultdict(list)
    base = robot.config.base
    if base is not None and base.chassis_mass:
        half = 0.5 * np.array(base.chassis_size)
        signs = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3), axis=-1).reshape(-1, 3)
        shapes["base"].append(signs * half + (0.0, 0.0, base.chassis_height))
    for shape in arm_shapes(robot, pin.GeometryType.COLLISION):
        link = link_in_model(robot, shape.name.rpartition("_")[0])
        frame = robot.pinocchio.frames[robot.frame(link)]
        place = frame.placement.actInv(shape.placement)
        shapes[link].append(_corners(shape) @ place.rotation.T + place.translation)
    return dict(shapes)


def spheres_of(robot: RobotModel, most: int, beyond: float) -> list[LinkSpheres]:
    """Return spheres for every link that can touch something.

    Args:
        robot: the robot; of meshes their convex hulls count, as they do in the simulation.
        most: how many spheres per link.
        beyond: by how much a sphere may stand out [m]; 0: as little as ``most`` allow.

    Raises:
        ModelError: there are no shapes, or ``most`` is too few; the text names the link.
    """
    shapes = shapes_by_link(robot)
    if not shapes:
        raise ModelError(f"robot {robot.name}: its URDF has no collision shapes, nor a chassis")
    found = []
    for link, corners in shapes.items():
        try:
            found.append(LinkSpheres(link, cover(corners, most, beyond)))
        except ModelError as error:
            raise ModelError(f"robot {robot.name}: link {link}: {error}") from error
    return found


def _corners(shape: Shape) -> Matrix:
    """Return corners whose hull holds a shape, in the shape's own frame."""
    if shape.is_primitive:
        kind, size = primitive(shape.geometry)
        corners = triangles(kind, size).vertices
        return corners if kind == mujoco.mjtGeom.mjGEOM_BOX else _ROUND * corners
    mesh = shape.mesh()
    if not is_flat(mesh):
        return mesh.vertices
    middle = mesh.vertices.mean(axis=0)
    normal = np.linalg.svd(mesh.vertices - middle)[2][2]
    return np.concatenate(
        [mesh.vertices - 0.5 * _THICK * normal, mesh.vertices + 0.5 * _THICK * normal]
    )
