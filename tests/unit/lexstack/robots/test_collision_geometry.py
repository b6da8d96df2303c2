"""Spheres and obstacles: where they are and how fast, against pinocchio and finite differences."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import ConfigurationError, ModelError
from lexstack.robots import ObstacleConfig, Obstacles, RobotModel, SphereConfig
from lexstack_config.reader import build
from support.scenario import random_q, state_at, team

STEP = 1e-6


def centers_by_pinocchio(q):
    """Return all centers, link by link, shape (s, 3)."""
    centers = []
    for robot, part in zip(team().robots, team().slices, strict=True):
        data = robot.pinocchio.createData()
        pin.framesForwardKinematics(robot.pinocchio, data, q[part])
        for sphere in robot.config.spheres:
            frame = robot.pinocchio.getFrameId(sphere.link, pin.FrameType.BODY)
            centers.append(data.oMf[frame].act(np.array(sphere.xyz)))
    return np.array(centers)


@pytest.mark.parametrize("seed", range(20))
def test_the_centers_are_where_pinocchio_has_them(seed):
    q = random_q(np.random.default_rng(seed))
    spheres = team().spheres(q)
    np.testing.assert_allclose(spheres.centers, centers_by_pinocchio(q), atol=1e-12)
    assert spheres.radii.shape == spheres.owners.shape == (len(spheres.centers),)


@pytest.mark.parametrize("seed", range(20))
def test_the_rows_are_the_derivative_of_the_centers(seed):
    rng = np.random.default_rng(seed)
    q = random_q(rng)
    spheres = team().spheres(q)
    chosen = rng.integers(len(spheres.radii), size=7)
    directions = rng.normal(size=(7, 3))
    rows = spheres.rows(chosen, directions)
    chi = rng.normal(size=team().n)
    ahead, behind = (centers_by_pinocchio(q + sign * STEP * chi) for sign in (1.0, -1.0))
    speeds = np.einsum("ij,ij->i", (ahead - behind)[chosen] / (2.0 * STEP), directions)
    np.testing.assert_allclose(rows @ chi, speeds, atol=1e-7)


def test_what_was_returned_does_not_change_with_the_next_call():
    rng = np.random.default_rng(0)
    first = team().spheres(random_q(rng))
    kept = first.centers.copy(), first.twists.copy()
    team().spheres(random_q(rng))
    np.testing.assert_array_equal(first.centers, kept[0])
    np.testing.assert_array_equal(first.twists, kept[1])


def test_spheres_are_made_once_a_tick_and_only_when_asked_for():
    kinematics = team().kinematics(state_at(random_q(np.random.default_rng(1))))
    assert kinematics.spheres is kinematics.spheres


def test_a_sphere_on_a_link_that_is_not_there_is_refused():
    config = team().robots[0].config
    wrong = SphereConfig("panda_link9", (0.0, 0.0, 0.0), 0.1)
    with pytest.raises(ModelError, match=r"robot r: spheres\[0\].link: no link 'panda_link9'"):
        RobotModel("r", dataclasses.replace(config, spheres=(wrong,)))


def test_a_robot_may_have_no_spheres():
    robot = RobotModel("r", dataclasses.replace(team().robots[0].config, spheres=()))
    centers, twists = robot.spheres.at(robot.home((0.0, 0.0, 0.0)))
    assert centers.shape == (3, 0)
    assert twists.shape == (6, robot.n)


# ---- obstacles


def test_obstacles_move_as_configured():
    """Straight on, and there and back in a period, from rest."""
    both = Obstacles(
        {
            "straight": ObstacleConfig((1.0, 2.0, 3.0), 0.1, velocity=(0.5, 0.0, -0.1)),
            "swinging": ObstacleConfig((0.0, 0.0, 1.0), 0.2, swing=(0.0, 2.0, 0.0), period=4.0),
        }
    )
    np.testing.assert_allclose(both.at(0.0), [[1.0, 2.0, 3.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(both.at(2.0), [[2.0, 2.0, 2.8], [0.0, 2.0, 1.0]])
    np.testing.assert_allclose(both.at(4.0), [[3.0, 2.0, 2.6], [0.0, 0.0, 1.0]], atol=1e-12)
    speed = (both.at(1.0 + STEP) - both.at(1.0 - STEP))[1, 1] / (2.0 * STEP)
    assert speed == pytest.approx(np.pi * 2.0 / 4.0)
    assert np.abs(both.at(STEP)[1] - both.at(0.0)[1]).max() < 1e-11, "it starts from rest"
    assert both.moving
    assert both.names == ("straight", "swinging")


def test_obstacles_that_stand_stand():
    still = Obstacles({"post": ObstacleConfig((1.0, 0.0, 0.5), 0.3)})
    assert not still.moving
    np.testing.assert_array_equal(still.at(0.0), still.at(100.0))
    assert not Obstacles({}).moving
    assert Obstacles({}).at(1.0).shape == (0, 3)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"radius": 0.0}, "here: radius: must be finite and > 0"),
        ({"radius": 0.1, "period": 0.0}, "here: period: must be finite and > 0"),
        (
            {"radius": 0.1, "velocity": [0.0, 0.0, float("inf")]},
            r"here: velocity\[2\]: must be finite",
        ),
        ({"radius": 0.1, "swing": [0.0, 0.0]}, "here: swing: expected 3 values, got 2"),
        ({"radius": 0.1, "speed": 1.0}, "here: unknown key 'speed'"),
    ],
)
def test_a_wrong_obstacle_is_refused(values, message):
    with pytest.raises(ConfigurationError, match=message):
        build(ObstacleConfig, {"position": [0.0, 0.0, 0.0], **values}, "here")
