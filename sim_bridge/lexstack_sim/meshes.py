"""The shapes in a robot's URDF, placed on the bodies that carry them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import coal
import mujoco
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_sim.geometry import LOADER, read_geometry

_FLAT = 1e-6  # m: a mesh thinner than this has no convex hull
_THIN = 5e-4  # m, half the thickness of the box in place of a flat mesh


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
    """A box, sphere, cylinder, capsule or triangle mesh on a link.

    Attributes:
        name: unique within the robot, e.g. ``panda_link3_0``.
        joint: number of the pinocchio joint that moves it.
        placement: in that joint's frame.
        path: the mesh's file.
        geometry: the primitive or the mesh itself.
        scale: by which the file's coordinates are multiplied, shape (3,).
        color: that the URDF gives it, red to alpha; None: it gives none.
    """

    name: str
    joint: int
    placement: pin.SE3
    path: Path
    geometry: coal.CollisionGeometry
    scale: Vector
    color: tuple[float, ...] | None

    def add_primitive(self, body: mujoco.MjsBody, **attributes: object) -> None:
        """Add a primitive to a body."""
        kind, size = primitive(self.geometry)
        body.add_geom(type=kind, size=size, **self._place(), **attributes)

    def add_mesh(
        self,
        spec: mujoco.MjSpec,
        body: mujoco.MjsBody,
        asset: str,
        mesh: Mesh,
        **attributes: object,
    ) -> None:
        """Add a mesh to a body; robots of one kind share the ``asset`` of that name."""
        if is_flat(mesh):
            self._add_sheet(body, mesh, **attributes)
            return
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
    def is_primitive(self) -> bool:
        """Whether it is no mesh."""
        return not isinstance(self.geometry, coal.BVHModelBase)

    def mesh(self) -> Mesh:
        """Return the triangles of the mesh as pinocchio has read it."""
        triangles = (self.geometry.tri_indices(i) for i in range(self.geometry.num_tris))
        faces = np.array([[t[0], t[1], t[2]] for t in triangles], dtype=np.int32)
        return Mesh(self.geometry.vertices(), faces)

    def _add_sheet(self, body: mujoco.MjsBody, mesh: Mesh, **attributes: object) -> None:
        """Add the thin box that holds a flat mesh, of which MuJoCo makes no geometry."""
        center = mesh.vertices.mean(axis=0)
        axes = np.linalg.svd(mesh.vertices - center)[2]
        axes[2] *= np.sign(np.linalg.det(axes))
        along = (mesh.vertices - center) @ axes.T
        lower, upper = along.min(axis=0), along.max(axis=0)
        local = pin.SE3(axes.T, center + axes.T @ (0.5 * (lower + upper)))
        size = np.maximum(0.5 * (upper - lower), _THIN)
        place = _as_mujoco(self.placement * local)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, **place, **attributes)

    def _place(self) -> dict[str, Vector]:
        """Return the placement as MuJoCo has it."""
        return _as_mujoco(self.placement)


def arm_shapes(robot: RobotModel, kind: pin.GeometryType) -> list[Shape]:
    """Return the collision or visual shapes of what a robot's URDF describes.

    Meshes that cannot be read are left out; ``missing_meshes`` names them.
    """
    arm = robot.config.arm
    if not arm.description:  # it was built from a pinocchio model
        return []
    urdf, geometry = _read(arm.description, arm.packages, kind)
    return [_shape(robot, urdf, item) for item in geometry.geometryObjects]


def missing_meshes(robot: RobotModel) -> tuple[str, ...]:
    """Return one line for each mesh of a robot's URDF that is not there or cannot be read."""
    arm = robot.config.arm
    if not arm.description:
        return ()
    found = read_geometry(arm.description, arm.packages, "collision").missing
    return tuple(f"robot {robot.name}: {line}" for line in found)


@lru_cache(maxsize=32)
def _read(
    description: str, packages: tuple[str, ...], kind: pin.GeometryType
) -> tuple[pin.Model, pin.GeometryModel]:
    """Return the model and the shapes in a URDF; several robots share them."""
    found = read_geometry(
        description, packages, "visual" if kind == pin.GeometryType.VISUAL else "collision"
    )
    urdf = pin.buildModelFromXML(found.text)
    geometry = pin.buildGeomFromUrdfString(urdf, found.text, kind, mesh_loader=LOADER)
    for item in geometry.geometryObjects:
        if item.name in found.capsules:
            item.geometry = coal.Capsule(item.geometry.radius, 2.0 * item.geometry.halfLength)
    return urdf, geometry


def _shape(robot: RobotModel, urdf: pin.Model, item: pin.GeometryObject) -> Shape:
    """Return one shape, moved from the URDF's joint to the joint of ``robot`` that carries it."""
    source = urdf.frames[item.parentFrame]
    target = robot.pinocchio.frames[robot.frame(link_in_model(robot, source.name))]
    placement = target.placement * source.placement.actInv(item.placement)
    color = tuple(float(value) for value in item.meshColor) if item.overrideMaterial else None
    return Shape(
        *(item.name, target.parentJoint, placement, Path(item.meshPath), item.geometry),
        *(item.meshScale, color),
    )


def link_in_model(robot: RobotModel, name: str) -> str:
    """Return a link's name in the model, where a platform's frame may have taken its own."""
    given_up = f"arm_{name}"
    taken = robot.pinocchio.existFrame(given_up, pin.FrameType.BODY)
    return given_up if taken else name


def is_flat(mesh: Mesh) -> bool:
    """Return whether all corners of a mesh lie in a plane."""
    if len(mesh.vertices) < 4:
        return True
    scatter = np.cov(mesh.vertices.T)
    return bool(np.linalg.eigvalsh(scatter)[0] < _FLAT**2)


def primitive(geometry: coal.CollisionGeometry) -> tuple[mujoco.mjtGeom, Vector]:
    """Return MuJoCo's kind and size of a primitive; its long axis is z in both."""
    kinds = mujoco.mjtGeom
    if isinstance(geometry, coal.Box):
        return kinds.mjGEOM_BOX, geometry.halfSide
    if isinstance(geometry, coal.Sphere):
        return kinds.mjGEOM_SPHERE, np.array([geometry.radius, 0.0, 0.0])
    kind = kinds.mjGEOM_CAPSULE if isinstance(geometry, coal.Capsule) else kinds.mjGEOM_CYLINDER
    return kind, np.array([geometry.radius, geometry.halfLength, 0.0])


def _as_mujoco(placement: pin.SE3) -> dict[str, Vector]:
    """Return a placement as MuJoCo has it."""
    rotation = np.empty(4)
    mujoco.mju_mat2Quat(rotation, placement.rotation.ravel())
    return {"pos": placement.translation, "quat": rotation}
