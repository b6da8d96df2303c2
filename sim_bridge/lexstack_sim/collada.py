"""Coloured meshes from COLLADA files: what common mesh loaders drop is the colours."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import defaultdict
from functools import lru_cache
from pathlib import Path

import numpy as np

from lexstack.errors import ModelError
from lexstack.types import Matrix
from lexstack_sim.meshes import Mesh

Color = tuple[float, ...]
_CELL = 0.004  # m, details smaller than this vanish
_GREY: Color = (0.7, 0.7, 0.7, 1.0)


@lru_cache(maxsize=32)
def read_collada(path: Path) -> dict[Color, Mesh]:
    """Return the triangles of a COLLADA file in metres, one mesh per colour (RGBA).

    Raises:
        ModelError: the file cannot be read.
    """
    try:
        root = ET.parse(path).getroot()  # noqa: S314 - of an installed package
    except (OSError, ET.ParseError) as error:
        raise ModelError(f"{path}: not a COLLADA file: {error}") from error
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    unit = root.find("asset/unit")
    scale = 1.0 if unit is None else float(unit.get("meter", "1"))
    colors = _colors(root)
    geometries = {item.get("id"): item for item in root.iter("geometry")}
    parts: dict[Color, list[Matrix]] = defaultdict(list)
    for node in root.iter("node"):
        matrix = _floats(node.findtext("matrix", _IDENTITY)).reshape(4, 4)
        for instance in node.findall("instance_geometry"):
            geometry = geometries[instance.get("url", "")[1:]]
            for triangles in geometry.iter("triangles"):
                corners = _corners(geometry, triangles) @ matrix[:3, :3].T + matrix[:3, 3]
                parts[colors.get(triangles.get("material"), _GREY)].append(scale * corners)
    return {color: clustered(np.concatenate(corners), _CELL) for color, corners in parts.items()}


_IDENTITY = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"


def _colors(root: ET.Element) -> dict[str | None, Color]:
    """Return the diffuse colour of every material."""
    effects = {
        effect.get("id"): tuple(
            _floats(effect.findtext(".//diffuse/color", "0.7 0.7 0.7 1")).tolist()
        )
        for effect in root.iter("effect")
    }
    return {
        material.get("id"): effects[instance.get("url", "")[1:]]
        for material in root.iter("material")
        for instance in material.findall("instance_effect")
    }


def _corners(geometry: ET.Element, triangles: ET.Element) -> Matrix:
    """Return the corners of triangles one after the other, shape (3 k, 3)."""
    sources = {item.get("id"): item.findtext("float_array", "") for item in geometry.iter("source")}
    positions = geometry.find(".//vertices/input[@semantic='POSITION']")
    inputs = triangles.findall("input")
    if positions is None:
        raise ModelError(f"COLLADA geometry {geometry.get('id')} has no positions")
    points = _floats(sources[positions.get("source", "")[1:]]).reshape(-1, 3)
    stride = 1 + max(int(item.get("offset", "0")) for item in inputs)
    offset = next(
        int(item.get("offset", "0")) for item in inputs if item.get("semantic") == "VERTEX"
    )
    indices = np.fromstring(triangles.findtext("p", ""), dtype=np.int64, sep=" ")
    return points[indices[offset::stride]]


def clustered(corners: Matrix, size: float) -> Mesh:
    """Return triangles as a mesh whose corners within one cell of a grid became their mean.

    With cells of 4 mm that leaves a quarter of a detailed mesh's triangles, and no difference to
    see.

    Args:
        corners: of triangles, one after the other, shape (3 k, 3), m.
        size: of a cell [m].
    """
    cells, cell = np.unique(np.floor(corners / size), axis=0, return_inverse=True)
    cell = cell.ravel()
    sums = [np.bincount(cell, corners[:, i], len(cells)) for i in range(3)]
    vertices = np.column_stack(sums) / np.bincount(cell)[:, np.newaxis]
    faces = cell.reshape(-1, 3)
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return Mesh(vertices, faces[distinct].astype(np.int32))


def _floats(text: str) -> Matrix:
    """Return the numbers in a text."""
    return np.fromstring(text, sep=" ")
