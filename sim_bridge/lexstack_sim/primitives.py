"""Triangles of MuJoCo's primitives, to draw them where only meshes are known."""

from __future__ import annotations

import mujoco
import numpy as np

from lexstack.types import Vector
from lexstack_sim.meshes import Mesh

_AROUND = 24  # corners of a circle
_UP = 6  # rings of half a sphere


def triangles(kind: mujoco.mjtGeom, size: Vector) -> Mesh:
    """Return a primitive's surface in its own frame; its long axis is z.

    Args:
        kind: sphere, capsule, cylinder, box or ellipsoid.
        size: as MuJoCo has it: half sides of a box; radius and half the length; [m].

    Raises:
        KeyError: it is none of these.
    """
    kinds = mujoco.mjtGeom
    radius, half = float(size[0]), float(size[1])
    quarter = np.linspace(0.0, 0.5 * np.pi, _UP + 1)
    arcs = np.column_stack([np.cos(quarter), np.sin(quarter)])  # from the rim to the pole
    if kind == kinds.mjGEOM_BOX:
        return _box(size)
    profiles = {
        kinds.mjGEOM_SPHERE: radius * arcs,
        kinds.mjGEOM_ELLIPSOID: arcs,
        kinds.mjGEOM_CAPSULE: radius * arcs + (0.0, half),
        # The rim twice: the edge between wall and lid is sharp.
        kinds.mjGEOM_CYLINDER: np.array([[radius, half], [radius, half], [0.0, half]]),
    }
    mesh = _turned(profiles[kind])
    return Mesh(mesh.vertices * size, mesh.faces) if kind == kinds.mjGEOM_ELLIPSOID else mesh


def _turned(upper: Vector) -> Mesh:
    """Return what a profile of radius and height, mirrored downwards, sweeps about z."""
    profile = np.concatenate([upper[::-1] * (1.0, -1.0), upper])
    angles = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    rings = [
        np.column_stack([r * np.cos(angles), r * np.sin(angles), np.full(_AROUND, z)])
        for r, z in profile
    ]
    here = np.arange(_AROUND)
    after = np.roll(here, -1)
    faces = [
        ring * _AROUND + corners
        for ring in range(len(profile) - 1)
        for corners in (
            np.column_stack([here, after, after + _AROUND]),
            np.column_stack([here, after + _AROUND, here + _AROUND]),
        )
    ]
    return Mesh(np.concatenate(rings), np.concatenate(faces).astype(np.int32))


def _box(half: Vector) -> Mesh:
    """Return a box with corners of its own on each side, so that its edges are sharp."""
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    sides, faces = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            corners = np.empty((4, 3))
            corners[:, axis] = sign
            corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3] = square.T
            start = 4 * len(sides)
            order = [[0, 1, 2], [0, 2, 3]] if sign > 0 else [[0, 2, 1], [0, 3, 2]]
            faces.append(start + np.array(order))
            sides.append(corners * half)
    return Mesh(np.concatenate(sides), np.concatenate(faces).astype(np.int32))
