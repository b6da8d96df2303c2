"""The shapes in an arm's URDF, placed on the bodies that carry them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import coal
import mujoco
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack.robots import RobotModel, description_path
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, slots=True)
class Mesh:
    """Triangles.

    Attributes:
        vertices: shape (m, 3), m.
        faces: indices of vertices, shape (k, 3).
    """

    vertices: Matrix
    faces: NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Shape:
    """A box or a triangle mesh on a link.

    Attributes:
        name: unique within the robot, e.g. ``panda_link3_0``.
        joint: number of the pinocchio joint that moves it.
        placement: in that joint's frame.
        path: the mesh's file.
        geometry: the box or the mesh itself.
    """

    name: str
    joint: int
    placement: pin.SE3
    path: Path
    geometry: coal.CollisionGeometry

    def add_box(self, body: mujoco.MjsBody, **attributes: object) -> None:
        """Add a box to a body."""
        size = self.geometry.halfSide
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, **self._place(), **attributes)

    def add_mesh(
        self,
        spec: mujoco.MjSpec,
        body: mujoco.MjsBody,
        asset: str,
        mesh: Mesh,
        **attributes: object,
    ) -> None:
        """Add a mesh to a body; robots of one kind share the ``asset`` of that name."""
        if spec.mesh(asset) is None:
            # Inertias are pinocchio's; a shell's is defined for an open surface too.
            spec.add_mesh(
                name=asset,
                uservert=mesh.vertices.ravel(),
                userface=mesh.faces.ravel(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
        kind = mujoco.mjtGeom.mjGEOM_MESH
        body.add_geom(type=kind, meshname=asset, **self._place(), **attributes)

    @property
    def is_box(self) -> bool:
        """Whether it is a box."""
        return isinstance(self.geometry, coal.Box)

    def mesh(self) -> Mesh:
        """Return the triangles of the mesh as pinocchio has read it."""
        triangles = (self.geometry.tri_indices(i) for i in range(self.geometry.num_tris))
        faces = np.array([[t[0], t[1], t[2]] for t in triangles], dtype=np.int32)
        return Mesh(self.geometry.vertices(), faces)

    def _place(self) -> dict[str, Vector]:
        """Return the placement as MuJoCo has it."""
        rotation = np.empty(4)
        mujoco.mju_mat2Quat(rotation, self.placement.rotation.ravel())
        return {"pos": self.placement.translation, "quat": rotation}


def arm_shapes(robot: RobotModel, kind: pin.GeometryType) -> list[Shape]:
    """Return the collision or visual shapes of a robot's arm, hand and fingers."""
    urdf, geometry = _read(description_path(robot.config.arm.description), kind)
    return [_shape(robot.pinocchio, urdf, item) for item in geometry.geometryObjects]


@lru_cache(maxsize=8)
def _read(path: Path, kind: pin.GeometryType) -> tuple[pin.Model, pin.GeometryModel]:
    """Return the model and the shapes in a URDF; several robots share them."""
    urdf = pin.buildModelFromUrdf(str(path))
    # Meshes are named package://example-robot-data/robots/...: the folder above that package.
    folder = str(path.parents[4])
    return urdf, pin.buildGeomFromUrdf(urdf, str(path), kind, package_dirs=[folder])


def _shape(model: pin.Model, urdf: pin.Model, item: pin.GeometryObject) -> Shape:
    """Return one shape, moved from the URDF's joint to the joint of ``model`` that carries it."""
    source = urdf.frames[item.parentFrame]
    target = model.frames[model.getFrameId(source.name)]
    placement = target.placement * source.placement.actInv(item.placement)
    return Shape(item.name, target.parentJoint, placement, Path(item.meshPath), item.geometry)
