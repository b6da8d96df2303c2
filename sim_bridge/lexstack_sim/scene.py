"""The robots as plain data for a viewer in the browser: bodies, joints, parts, small meshes.

A viewer nests the bodies as here, sets every joint to its entry of q, and draws the parts. Lengths
are metres; quaternions are x, y, z, w; all poses are in the frame of the body or, for a body, of
its parent.
"""

from __future__ import annotations

import base64
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_sim.collada import clustered
from lexstack_sim.coordinates import Coordinates
from lexstack_sim.meshes import Mesh
from lexstack_sim.world import build_world

_CELL = 0.007  # m, details smaller than this vanish
_COARSEST = 0.1  # m
_LARGEST = 600_000  # characters of all meshes
_SEEN = 1  # the group of geoms that are for the eye
_KINDS = {
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
}
_LEVELS = 65535  # of a coordinate within its mesh's box

Plain = dict[str, Any]


def scene(team: Team) -> Plain:
    """Return what a viewer needs to draw a team at any q.

    Returns:
        ``robots``: names in the order of chi. ``bodies``: parents first; ``parent`` is an index
        of the list or -1; ``joints`` act one after the other in the body's frame, ``index`` is
        the joint's place in q, and its position is ``ratio`` times that entry, plus ``offset``
        (joints that mimic another). ``parts``: shapes of a body. ``meshes``: what parts refer to,
        coordinates as 16-bit steps from ``lower``.
    """
    world = build_world(team, visuals=True)
    followed = _followed(world, team)
    numbers: dict[int, int] = {}  # of the meshes that are used
    # Obstacles move with the clock, not with q: the viewer draws them itself.
    moved = [i for i in range(1, world.nbody) if world.body_mocapid[i] < 0]
    places = {number: place for place, number in enumerate(moved)}
    bodies = [_body(world, i, places, numbers, followed) for i in moved]
    return {
        "robots": list(team.names),
        "bodies": bodies,
        "meshes": _meshes(world, list(numbers)),
    }


def _followed(world: mujoco.MjModel, team: Team) -> list[tuple[int, float, float]]:
    """Return for each joint of the world which entry of q it follows, by what ratio and offset."""
    coordinates = Coordinates(world, team)
    matrix, offsets = coordinates.matrix, np.zeros(world.njnt)
    offsets[coordinates.followers] = coordinates.offsets
    entries = [int(np.flatnonzero(row)[0]) for row in matrix]
    ratios = matrix[np.arange(len(entries)), entries]
    return list(zip(entries, ratios.tolist(), offsets.tolist(), strict=True))


def _body(
    world: mujoco.MjModel,
    number: int,
    places: dict[int, int],
    meshes: dict[int, int],
    followed: list[tuple[int, float, float]],
) -> Plain:
    """Return one body with its joints and parts; ``places`` of the bodies in the list."""
    first, count = int(world.body_jntadr[number]), int(world.body_jntnum[number])
    parts = [
        _part(world, i, meshes)
        for i in np.flatnonzero(world.geom_bodyid == number)
        if world.geom_group[i] == _SEEN
    ]
    return {
        "name": world.body(number).name,
        "parent": places.get(int(world.body_parentid[number]), -1),
        **_pose(world.body_pos[number], world.body_quat[number]),
        "joints": [
            {
                **dict(zip(("index", "ratio", "offset"), followed[j], strict=True)),
                "slides": world.jnt_type[j] == mujoco.mjtJoint.mjJNT_SLIDE,
                "axis": world.jnt_axis[j].tolist(),
            }
            for j in range(first, first + count)
        ],
        "parts": parts,
    }


def _part(world: mujoco.MjModel, number: int, meshes: dict[int, int]) -> Plain:
    """Return one shape of a body; notes the mesh that it uses."""
    kind = _KINDS[mujoco.mjtGeom(int(world.geom_type[number]))]
    part: Plain = {
        "kind": kind,
        "color": np.round(world.geom_rgba[number], 3).tolist(),
        **_pose(world.geom_pos[number], world.geom_quat[number]),
    }
    if kind == "mesh":
        mesh = int(world.geom_dataid[number])
        part["mesh"] = meshes.setdefault(mesh, len(meshes))
    else:
        part["size"] = np.round(world.geom_size[number], 5).tolist()
    return part


def _pose(position: Vector, quaternion: Vector) -> Plain:
    """Return a pose of MuJoCo as plain data."""
    w, x, y, z = np.round(quaternion, 7).tolist()
    return {"position": np.round(position, 6).tolist(), "quaternion": [x, y, z, w]}


def _meshes(world: mujoco.MjModel, numbers: list[int]) -> list[Plain]:
    """Return meshes as fine as they may be together, so that a page stays small."""
    cell = _CELL
    while True:
        found = [_mesh(world, number, cell) for number in numbers]
        size = sum(len(mesh["vertices"]) + len(mesh["faces"]) for mesh in found)
        if size <= _LARGEST or cell > _COARSEST:
            return found
        cell *= max(1.2, (size / _LARGEST) ** 0.5)  # corners of a surface go with 1 / cell^2


def _mesh(world: mujoco.MjModel, number: int, cell: float) -> Plain:
    """Return one mesh with fewer triangles, details in one ``cell`` [m] joined, as 16-bit steps."""
    start, count = world.mesh_vertadr[number], world.mesh_vertnum[number]
    vertices = world.mesh_vert[start : start + count].astype(np.float64)
    start, count = world.mesh_faceadr[number], world.mesh_facenum[number]
    small = clustered(vertices[world.mesh_face[start : start + count].ravel()], cell)
    small = small if len(small.faces) else Mesh(vertices, world.mesh_face[start : start + count])
    lower = small.vertices.min(axis=0)
    step = np.maximum(np.ptp(small.vertices, axis=0), 1e-9) / _LEVELS
    places = np.round((small.vertices - lower) / step)
    return {
        "lower": lower.tolist(),
        "step": step.tolist(),
        "vertices": _packed(places.astype("<u2")),
        "faces": _packed(small.faces.astype("<u2" if len(places) <= _LEVELS else "<u4")),
        "wide": len(places) > _LEVELS,
    }


def _packed(array: NDArray[Any]) -> str:
    """Return an array's bytes in base64."""
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
