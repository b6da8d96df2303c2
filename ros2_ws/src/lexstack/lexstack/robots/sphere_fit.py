"""Spheres that cover convex shapes, and stand out of them by as little as their number allows.

A sphere about a point c at the depth d(c) below the surface of a convex shape, with the radius
d(c) + e, stands out by at most e: the sphere of radius d(c) is inside, and no point of the larger
one is farther than e from it. So n spheres cover the points s_i of the surface and stand out by

    e = max_i min_j (|s_i - c_j| - d(c_j))

Their places are those of a k-centre problem with this distance, which is solved as k-means is:
every point goes to the sphere that is best for it, and every sphere to the place that is best for
its points, in turns (Lloyd 1982); the best of several starts counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.distance import cdist

from lexstack.errors import ModelError
from lexstack.types import Matrix, Vector

_CANDIDATES = 14  # places along the longest side of a shape
_SAMPLES = 30  # along its longest side
_STARTS = 4  # of which the best counts
_FINER = 4  # times as many samples, for the radii
_ROUNDING = 1e-9  # m
_LARGEST = 1e6  # m, of a corner
_FINEST = 1e-3  # m, between samples


Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Covering:
    """Spheres that cover some shapes.

    Attributes:
        centers: shape (s, 3), m.
        radii: shape (s,), m.
        beyond: by how much a sphere stands out of the shapes at most [m].
    """

    centers: Matrix
    radii: Vector
    beyond: float


@dataclass(frozen=True, slots=True)
class _Sampled:
    """The surface of all shapes as points, and the places where spheres may be.

    Attributes:
        distances: from each place to each point, and as far as the surface around that point
            reaches, less the depth of the place, shape (places, points), m.
        places: shape (places, 3), m.
        depths: of the places below the surface, shape (places,), m.
    """

    distances: Matrix
    places: Matrix
    depths: Vector


def cover(shapes: list[Matrix], most: int, beyond: float = 0.0) -> Covering:
    """Return spheres that cover convex shapes, such as those of one link.

    Every point of the surfaces is inside a sphere: the samples are counted with the part of the
    surface around them.

    Args:
        shapes: the corners of each, shape (m, 3), in one frame [m].
        most: how many spheres at most.
        beyond: by how much they may stand out [m]: as few as that takes, if that is fewer than
            ``most``; 0: all of them, standing out by as little as they can.

    Raises:
        ModelError: a shape is flat, or ``most`` or ``beyond`` is not enough.
    """
    if most < 1 or not beyond >= 0.0:
        raise ModelError(f"expected at least one sphere and beyond >= 0, got {most}, {beyond}")
    if not shapes:
        raise ModelError("there is no shape to cover")
    hulls = [_hull(corners) for corners in shapes]
    sampled = _sampled(hulls)
    rng = np.random.default_rng(0)
    for number in range(1 if beyond else most, most + 1):
        starts = (_start(sampled.distances, number, rng) for _ in range(_STARTS))
        chosen, _ = min(
            (_places(sampled.distances, start) for start in starts), key=lambda found: found[1]
        )
        covering = _tightened(hulls, sampled.places[chosen], sampled.depths[chosen])
        if covering.beyond <= beyond:
            return covering
    if beyond:
        raise ModelError(
            f"{most} spheres stand out by {1e3 * covering.beyond:.1f} mm, "
            f"more than {1e3 * beyond:.1f} mm"
        )
    return covering


def _start(distances: Matrix, number: int, rng: np.random.Generator) -> Indices:
    """Return places to begin with: each next one is best for the point that is worst off."""
    chosen = [int(rng.integers(len(distances)))]
    for _ in range(number - 1):
        worst = int(np.argmax(distances[chosen].min(axis=0)))
        chosen.append(int(np.argmin(distances[:, worst])))
    return np.array(chosen)


def _places(distances: Matrix, chosen: Indices) -> tuple[Indices, float]:
    """Return the places to which some of them move, and e there [m]."""
    reached = float(distances[chosen].min(axis=0).max())
    while True:
        nearest = np.argmin(distances[chosen], axis=0)
        moved = [
            int(np.argmin(distances[:, nearest == j].max(axis=1)))
            if (nearest == j).any()
            else place
            for j, place in enumerate(chosen)
        ]
        now = float(distances[moved].min(axis=0).max())
        if not now < reached:
            return chosen, reached
        chosen, reached = np.array(moved), now


def _tightened(hulls: list[ConvexHull], centers: Matrix, depths: Vector) -> Covering:
    """Return spheres as small as their points need, by finer samples; useless ones are left out."""
    surface, reach = _shown(hulls, _FINER * _SAMPLES)
    distances = cdist(centers, surface) + reach - depths[:, None]
    nearest = np.argmin(distances, axis=0)
    used = np.unique(nearest)
    beyond = np.array([distances[j, nearest == j].max() for j in used])
    return Covering(centers[used], depths[used] + beyond, float(beyond.max()))


def _hull(corners: Matrix) -> ConvexHull:
    """Return the hull of corners; raises ModelError for flat ones."""
    if np.ndim(corners) != 2 or np.shape(corners)[1] != 3:
        raise ModelError(f"corners: expected shape (m, 3), got {np.shape(corners)}")
    if not np.abs(corners).max(initial=0.0) <= _LARGEST:
        raise ModelError(
            f"a corner is not a number, or farther than {_LARGEST:g} m from the origin"
        )
    try:
        return ConvexHull(corners)
    except (QhullError, ValueError) as error:
        raise ModelError(f"a shape of {len(corners)} corners has no volume") from error


def _sampled(hulls: list[ConvexHull]) -> _Sampled:
    """Return the surface and the places of some hulls."""
    places = []
    for hull in hulls:
        lower, upper = hull.points.min(axis=0), hull.points.max(axis=0)
        step = float((upper - lower).max()) / _CANDIDATES
        grid = [_between(a, b, step) for a, b in zip(lower, upper, strict=True)]
        places.append(np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1).reshape(-1, 3))
    every = np.concatenate(places)
    depths = _depths(hulls, every)
    every, depths = every[depths > 0.0], depths[depths > 0.0]
    surface, reach = _shown(hulls, _SAMPLES)
    return _Sampled(cdist(every, surface) + reach - depths[:, None], every, depths)


def _shown(hulls: list[ConvexHull], samples: int) -> tuple[Matrix, Vector]:
    """Return points on the surface of all hulls together, and how far each one's part reaches."""
    points, around = [], []
    for hull in hulls:
        side = float((hull.points.max(axis=0) - hull.points.min(axis=0)).max())
        surface, reach = _surface(hull, max(side / samples, _FINEST))
        points.append(surface)
        around.append(reach)
    surface, reach = np.concatenate(points), np.concatenate(around)
    if len(hulls) == 1:
        return surface, reach
    # What lies inside another shape of the same link is no surface of it.
    outside = _depths(hulls, surface) <= _ROUNDING
    return surface[outside], reach[outside]


def _between(lower: float, upper: float, step: float) -> Vector:
    """Return places along a side, its middle among them."""
    half = max(1, round(0.5 * (upper - lower) / step))
    places: Vector = np.linspace(lower, upper, 2 * half + 1)
    return places[1:-1]


def _depths(hulls: list[ConvexHull], points: Matrix) -> Vector:
    """Return how deep points are below the surface, at least, shape (points,); negative outside."""
    deepest: Vector = np.full(len(points), -np.inf)
    for hull in hulls:
        normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
        deepest = np.maximum(deepest, (-(points @ normals.T) - offsets).min(axis=1))
    return deepest


def _surface(hull: ConvexHull, step: float) -> tuple[Matrix, Vector]:
    """Return points on a hull, and how far the surface that each stands for reaches from it.

    Triangles larger than ``step`` are cut into equal smaller ones, whose centroids are the points;
    of points nearer to each other than that one stands for all.
    """
    corners = hull.points[hull.simplices]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.maximum(1, np.ceil(edges / step)).astype(np.intp)
    middles = corners.mean(axis=1)
    # A small triangle is a copy of the large one, parts times as small.
    reaches = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1) / parts
    points = [_centroids(int(n)) @ triangle for n, triangle in zip(parts, corners, strict=True)]
    around = np.repeat(reaches, parts**2)
    return _thinned(np.concatenate(points), around, step)


def _thinned(points: Matrix, around: Vector, step: float) -> tuple[Matrix, Vector]:
    """Return the point nearest to the middle of each cell of a grid: it stands for the others."""
    cells = np.floor(points / step)
    off = np.linalg.norm(points - step * (cells + 0.5), axis=1)
    order = np.lexsort((off, *cells.T))
    _, first, cell_of = np.unique(cells[order], axis=0, return_index=True, return_inverse=True)
    kept = points[order][first]
    cell_of = cell_of.reshape(-1)
    reach: Vector = np.zeros(len(kept))
    far = np.linalg.norm(points[order] - kept[cell_of], axis=1) + around[order]
    np.maximum.at(reach, cell_of, far)
    return kept, reach


def _centroids(parts: int) -> Matrix:
    """Return the centroids of the parts^2 triangles of a triangle, as weights, shape (m, 3)."""
    up = [(i + 1 / 3, j + 1 / 3) for i in range(parts) for j in range(parts - i)]
    down = [(i + 2 / 3, j + 2 / 3) for i in range(parts - 1) for j in range(parts - 1 - i)]
    first = np.array(up + down) / parts
    return np.column_stack([first, 1.0 - first.sum(axis=1)])
