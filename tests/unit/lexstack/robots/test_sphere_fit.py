"""Fitted spheres: they cover shapes to the last point, and stand out by no more than they say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from lexstack.errors import ModelError
from lexstack.robots import cover

BOX = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.3, 0.3)])


def on_surface(corners, rng, number=4000):
    """Return random points of the surface of a hull."""
    hull = ConvexHull(corners)
    triangles = corners[hull.simplices]
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    chosen = triangles[rng.choice(len(triangles), number, p=areas / areas.sum())]
    return np.einsum("nk,nkd->nd", rng.dirichlet(np.ones(3), number), chosen)


def outside(points, covering):
    """Return how far the point farthest from all spheres is from the nearest of them [m]."""
    away = np.linalg.norm(points[:, None] - covering.centers, axis=2) - covering.radii
    return away.min(axis=1).max()


def stands_out(corners, covering, rng):
    """Return by how much spheres stand out of one hull, by random points on them [m]."""
    hull = ConvexHull(corners)
    ways = rng.normal(size=(3000, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    worst = -np.inf
    for center, radius in zip(covering.centers, covering.radii, strict=True):
        points = center + radius * ways
        beyond = (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
        worst = max(worst, beyond.max())  # at most the distance to the hull: a bound from below
    return worst


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=st.integers(0, 1000), number=st.integers(1, 6))
def test_random_hulls_are_covered_and_the_error_is_as_told(seed, number):
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1.0, 1.0, (12, 3)) * rng.uniform(0.02, 0.4, 3)
    covering = cover([corners], number)
    assert 1 <= len(covering.radii) <= number
    assert outside(on_surface(corners, rng), covering) <= 0.0
    assert stands_out(corners, covering, rng) <= covering.beyond + 1e-12


def test_two_shapes_of_one_link_are_covered_together():
    other = BOX[:, [2, 0, 1]] * 0.5 + (0.2, 0.0, 0.1)
    covering = cover([BOX, other], 10)
    rng = np.random.default_rng(1)
    points = np.concatenate([on_surface(BOX, rng), on_surface(other, rng)])
    assert outside(points, covering) <= 0.0


def test_more_spheres_stand_out_less_and_one_is_the_smallest_around_a_box():
    errors = [cover([BOX], number).beyond for number in (1, 2, 4, 8)]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.3 * errors[0]
    least = np.linalg.norm(BOX[0]) - 0.05  # of the sphere around the middle, whose depth is 5 cm
    assert least <= errors[0] <= 1.05 * least


def test_as_few_as_an_error_takes():
    covering = cover([BOX], 30, beyond=0.06)
    assert covering.beyond <= 0.06
    assert cover([BOX], len(covering.radii) - 2).beyond > 0.06


@pytest.mark.parametrize(
    ("shapes", "most", "beyond", "told"),
    [
        ([BOX[:, :3] * (1.0, 1.0, 0.0)], 3, 0.0, "no volume"),
        ([BOX], 2, 0.01, "2 spheres stand out by"),
        ([BOX], 0, 0.0, "at least one sphere"),
        ([BOX], 1, np.nan, "beyond >= 0"),
    ],
)
def test_what_cannot_be_is_told(shapes, most, beyond, told):
    with pytest.raises(ModelError, match=told):
        cover(shapes, most, beyond)


@pytest.mark.parametrize(
    ("shapes", "told"),
    [
        ([], "no shape"),
        ([np.eye(4)[:, :2]], r"expected shape \(m, 3\), got \(4, 2\)"),
        ([1e300 * np.vstack([np.zeros(3), np.eye(3)])], "farther than 1e.06 m"),
        ([np.nan * np.vstack([np.zeros(3), np.eye(3)])], "not a number"),
    ],
)
def test_shapes_that_are_none_are_refused(shapes, told):
    with pytest.raises(ModelError, match=told):
        cover(shapes, 3)
