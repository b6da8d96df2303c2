"""The robots as triangles in the frames of their links, and where the links are at any q."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np
import pinocchio as pin

from lexstack.robots import Team
from lexstack.types import Matrix, Vector
from lexstack_sim.collada import clustered
from lexstack_sim.coordinates import Coordinates
from lexstack_sim.meshes import Mesh
from lexstack_sim.primitives import triangles
from lexstack_sim.world import build_world

_CELL = 0.007  # m, details smaller than this vanish
_SEEN = 1  # the group of geoms that are for the eye

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Surface:
    """What of a link has one colour.

    Attributes:
        mesh: triangles in the link's frame, m.
        color: red, green, blue and alpha, 0 to 1.
    """

    mesh: Mesh
    color: Rgba


class Drawing:
    """All that moves with q, link by link.

    Attributes:
        surfaces: of each link that has any, by colour.
    """

    def __init__(self, team: Team) -> None:
        """Build the world with all that the eye needs; raises ModelError."""
        self._world = build_world(team, visuals=True)
        self._data = mujoco.MjData(self._world)
        self._coordinates = Coordinates(self._world, team)
        # Obstacles move with the clock, not with q; body 0 is the floor.
        moved = [i for i in range(1, self._world.nbody) if self._world.body_mocapid[i] < 0]
        found = {i: tuple(self._surfaces_of(i)) for i in moved}
        self._bodies = [i for i in moved if found[i]]
        self.surfaces = tuple(found[i] for i in self._bodies)

    def poses(self, q: Vector) -> tuple[Matrix, Matrix]:
        """Return where the links are at q, shape (n,).

        Returns:
            positions in the world [m], shape (b, 3), and quaternions w, x, y, z, shape (b, 4).
        """
        self._coordinates.put(self._data, q)
        mujoco.mj_kinematics(self._world, self._data)
        return self._data.xpos[self._bodies].copy(), self._data.xquat[self._bodies].copy()

    def _surfaces_of(self, body: int) -> Iterator[Surface]:
        """Yield what is seen of a body, one surface for each colour."""
        by_color: dict[Rgba, list[Mesh]] = defaultdict(list)
        for geom in np.flatnonzero(self._world.geom_bodyid == body):
            if self._world.geom_group[geom] == _SEEN:
                red, green, blue, alpha = np.round(self._world.geom_rgba[geom], 3).tolist()
                by_color[red, green, blue, alpha].append(self._placed(int(geom)))
        for color, meshes in by_color.items():
            yield Surface(_joined(meshes), color)

    def _placed(self, geom: int) -> Mesh:
        """Return the triangles of a geom in its body's frame."""
        world = self._world
        kind = mujoco.mjtGeom(int(world.geom_type[geom]))
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = _coarse(_mesh(world, int(world.geom_dataid[geom])))
        else:
            mesh = triangles(kind, world.geom_size[geom])
        w, x, y, z = world.geom_quat[geom]
        rotation = pin.Quaternion(w, x, y, z).toRotationMatrix()
        return Mesh(mesh.vertices @ rotation.T + world.geom_pos[geom], mesh.faces)


def _mesh(world: mujoco.MjModel, number: int) -> Mesh:
    """Return one mesh of the world."""
    start, count = world.mesh_vertadr[number], world.mesh_vertnum[number]
    vertices = world.mesh_vert[start : start + count].astype(np.float64)
    start, count = world.mesh_faceadr[number], world.mesh_facenum[number]
    return Mesh(vertices, world.mesh_face[start : start + count])


def _coarse(mesh: Mesh) -> Mesh:
    """Return a mesh with fewer triangles; one that would vanish stays as it is."""
    small = clustered(mesh.vertices[mesh.faces.ravel()], _CELL)
    return small if len(small.faces) else mesh


def _joined(meshes: list[Mesh]) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(faces).astype(np.int32),
    )
