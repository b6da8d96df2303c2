"""The shapes in an arm's URDF, placed on the bodies that carry them."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import mujoco
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack_core.linear import Matrix
from lexstack_core.model import RobotModel
from lexstack_core.model.description import description_path


@dataclass(frozen=True, slots=True)
class Shape:
    """A box or a triangle mesh on a link.

    Attributes:
        name: unique within the robot, e.g. ``panda_link3_0``.
        link: the URDF link that it belongs to.
        joint: number of the pinocchio joint that moves it.
        placement: in that joint's frame.
        size: half sizes of a box, shape (3,), m; empty for a mesh.
        vertices: shape (m, 3), m; empty for a box.
        faces: indices of vertices, shape (k, 3).
    """

    name: str
    link: str
    joint: int
    placement: pin.SE3
    size: Matrix
    vertices: Matrix
    faces: NDArray[np.int32]

    def add_to(
        self, spec: mujoco.MjSpec, body: mujoco.MjsBody, prefix: str, **attributes: object
    ) -> mujoco.MjsGeom:
        """Add the shape to its body as a geom named ``prefix/name``; meshes are shared."""
        rotation = np.empty(4)
        mujoco.mju_mat2Quat(rotation, self.placement.rotation.ravel())
        place = {"pos": self.placement.translation, "quat": rotation, **attributes}
        name = f"{prefix}/{self.name}"
        if self.size.size:
            return body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, size=self.size, **place)
        spec.add_mesh(name=name, uservert=self.vertices.ravel(), userface=self.faces.ravel())
        return body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **place)


def arm_shapes(robot: RobotModel, kind: pin.GeometryType) -> list[Shape]:
    """Return the collision or visual shapes of a robot's arm, hand and fingers."""
    path = description_path(robot.config.arm.description)
    urdf = pin.buildModelFromUrdf(str(path))
    # Meshes are named package://example-robot-data/robots/...: the folder above that package.
    geometry = pin.buildGeomFromUrdf(urdf, str(path), kind, package_dirs=[str(path.parents[4])])
    return [_shape(robot.pinocchio, urdf, item) for item in geometry.geometryObjects]


def _shape(model: pin.Model, urdf: pin.Model, item: pin.GeometryObject) -> Shape:
    """Return one shape, moved from the URDF's joint to the joint of ``model`` that carries it."""
    source = urdf.frames[item.parentFrame]
    target = model.frames[model.getFrameId(source.name)]
    placement = target.placement * source.placement.actInv(item.placement)
    geometry = item.geometry
    size, vertices, faces = np.empty(0), np.empty((0, 3)), np.empty((0, 3), np.int32)
    if isinstance(geometry, coal.Box):
        size = geometry.halfSide.copy()
    else:
        vertices = geometry.vertices() * item.meshScale
        triangles = (geometry.tri_indices(i) for i in range(geometry.num_tris))
        faces = np.array([[t[0], t[1], t[2]] for t in triangles], dtype=np.int32)
    return Shape(item.name, source.name, target.parentJoint, placement, size, vertices, faces)
