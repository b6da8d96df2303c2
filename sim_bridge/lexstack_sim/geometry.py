"""A URDF as pinocchio can read its shapes: meshes found, those that cannot be read left out."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import coal
import numpy as np

from lexstack.errors import ModelError
from lexstack.robots import description_path, is_text, located, urdf_text
from lexstack.types import Vector

_SCHEMES = ("package://", "model://", "file://")

LOADER = coal.CachedMeshLoader()
"""Reads meshes: whether one can be read is known once it was, so it is kept for pinocchio."""


@dataclass(frozen=True, slots=True)
class Geometry:
    """The visual or the collision shapes that a URDF names.

    Attributes:
        text: the URDF with these shapes alone and absolute paths of meshes; those that cannot be
            read are not in it, and each capsule, which no URDF parser knows, is a cylinder.
        capsules: names by which pinocchio calls these.
        missing: of each mesh that is left out, in one line, why; those of the other kind of shape
            too, if they are not there.
    """

    text: str
    capsules: frozenset[str]
    missing: tuple[str, ...]


@lru_cache(maxsize=32)
def read_geometry(description: str, packages: tuple[str, ...], wanted: str) -> Geometry:
    """Return what a URDF says of its shapes of one kind.

    A mesh's path begins at the URDF's folder. ``package://NAME/...`` is looked up in the ament
    index, in ``packages``, and then in the folders above the URDF, as example-robot-data needs it.

    Args:
        description: as ``lexstack.robots.located`` returned it.
        packages: absolute folders that are packages or have packages in them.
        wanted: ``visual`` or ``collision``.
    """
    folder = None if is_text(description) else description_path(description).parent
    root = ET.fromstring(urdf_text(description))  # noqa: S314 - the robot was built from it
    missing: dict[str, None] = {}
    capsules: list[str] = []
    for link in root.findall("link"):
        name = link.get("name", "")
        for kind in ("visual", "collision"):
            for shape in link.findall(kind):
                reason = _prepare(shape, folder, packages, load=kind == wanted)
                if reason:
                    missing[f"link {name!r}: {kind}: {reason}; it is left out"] = None
                if reason or kind != wanted:
                    link.remove(shape)
        capsules += _capsules(link.findall(wanted), name)
    return Geometry(ET.tostring(root, encoding="unicode"), frozenset(capsules), tuple(missing))


def _prepare(
    shape: ET.Element, folder: Path | None, packages: tuple[str, ...], *, load: bool
) -> str:
    """Give a shape's mesh its absolute path; return why there is none, or ''."""
    mesh = shape.find("geometry/mesh")
    if mesh is None:
        return ""
    try:
        path = mesh_path(mesh.get("filename", ""), folder, packages)
        if load:
            _read(path, np.array([float(each) for each in mesh.get("scale", "1 1 1").split()]))
    except ModelError as error:
        return str(error)
    mesh.set("filename", str(path))
    return ""


def _capsules(shapes: list[ET.Element], link: str) -> list[str]:
    """Turn the capsules of a link into cylinders; return pinocchio's names of them."""
    names = []
    for i, shape in enumerate(shapes):
        capsule = shape.find("geometry/capsule")
        if capsule is not None:
            capsule.tag = "cylinder"
            names.append(f"{link}_{i}")
    return names


def mesh_path(name: str, folder: Path | None, packages: tuple[str, ...] = ()) -> Path:
    """Return where a mesh lies; raises ModelError where it is not.

    Args:
        name: ``package://...``, ``model://...``, ``file://...``, or a path.
        folder: of the URDF; None: it has none, and the path is absolute.
        packages: as in ``read_geometry``.
    """
    scheme = next((each for each in _SCHEMES if name.startswith(each)), "")
    rest = name.removeprefix(scheme)
    if scheme in ("package://", "model://"):
        try:
            return Path(located(f"package://{rest}", None, packages))
        except ModelError:
            above = (folder, *folder.parents) if folder else ()
            # A package's own folder may have another name than the package.
            found = [each / tail for tail in (rest, rest.partition("/")[2]) for each in above]
    elif scheme or folder is None:
        found = [Path(rest)]
    else:
        found = [folder / rest]
    for path in found:
        if os.path.isfile(path):  # noqa: PTH113 - False, not an error, for what is no path
            return path.resolve()
    raise ModelError(f"there is no mesh {name}")


def _read(path: Path, scale: Vector) -> None:
    """Raise ModelError for a mesh that has no triangles or cannot be read."""
    try:
        mesh = LOADER.load(str(path), scale)
    except ValueError as error:
        reason = " ".join(str(error).rpartition("message:")[2].split())
        raise ModelError(f"the mesh {path.name} cannot be read: {reason}") from error
    if not mesh.num_tris:
        raise ModelError(f"the mesh {path.name} has no triangles")
