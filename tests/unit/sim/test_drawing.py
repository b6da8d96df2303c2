"""The robots as triangles: every configured robot, its links where pinocchio has them."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from lexstack.robots import RobotModel, Team, from_quaternion
from lexstack_config.resolved import load_robot
from lexstack_sim.drawing import Drawing
from lexstack_sim.primitives import triangles
from support.scenario import random_q, team

ROBOTS = sorted((Path(__file__).parents[3] / "config/robots").glob("*.yaml"))


def volume(mesh):
    """Return what a closed surface holds; negative where its triangles face inwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_every_robot_can_be_drawn(path):
    one = Team((RobotModel("one", load_robot(path)),), 0.01)
    drawing = Drawing(one)
    positions, quaternions = drawing.poses(one.home())
    assert len(positions) == len(quaternions) == len(drawing.surfaces) > 0
    for surfaces in drawing.surfaces:
        for surface in surfaces:
            assert surface.mesh.faces.min() >= 0
            assert surface.mesh.faces.max() < len(surface.mesh.vertices)
            assert np.isfinite(surface.mesh.vertices).all()
            assert np.abs(surface.mesh.vertices).max() < 3.0  # m, from the link's origin


def test_links_are_where_pinocchio_has_them():
    drawing = Drawing(team())
    q = random_q(np.random.default_rng(4))
    positions, quaternions = drawing.poses(q)
    expected = []
    for robot, part in zip(team().robots, team().slices, strict=True):
        data = robot.pinocchio.createData()
        pin.forwardKinematics(robot.pinocchio, data, robot.positions(q[part]))
        expected += list(data.oMi)[1:]
    for place, (w, x, y, z) in zip(positions, quaternions, strict=True):
        rotation = from_quaternion(np.array([x, y, z, w]))
        assert any(
            np.allclose(place, one.translation, atol=1e-6)
            and np.allclose(rotation, one.rotation, atol=1e-6)
            for one in expected
        )


@pytest.mark.parametrize(
    ("kind", "size", "expected"),
    [
        (mujoco.mjtGeom.mjGEOM_BOX, (0.1, 0.2, 0.3), 8 * 0.006),
        (mujoco.mjtGeom.mjGEOM_SPHERE, (0.2, 0.0, 0.0), 4 / 3 * np.pi * 0.008),
        (mujoco.mjtGeom.mjGEOM_ELLIPSOID, (0.1, 0.2, 0.3), 4 / 3 * np.pi * 0.006),
        (mujoco.mjtGeom.mjGEOM_CYLINDER, (0.2, 0.3, 0.0), np.pi * 0.04 * 0.6),
        (mujoco.mjtGeom.mjGEOM_CAPSULE, (0.2, 0.3, 0.0), np.pi * (0.04 * 0.6 + 4 / 3 * 0.008)),
    ],
)
def test_primitives_hold_their_volume_and_face_outwards(kind, size, expected):
    assert volume(triangles(kind, np.array(size))) == pytest.approx(expected, rel=0.03)
