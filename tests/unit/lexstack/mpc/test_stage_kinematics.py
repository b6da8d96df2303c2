"""The generated kinematics are those of pinocchio, and their Jacobians those of differences."""

import numpy as np
import pytest

from lexstack.errors import ModelError
from lexstack.mpc import StageModel
from support.htmpc import ROBOTS, robot, sphere_centers

STEP = 1e-6


def spheres_of(which):
    return tuple(range(len(robot(which).config.spheres)))


@pytest.mark.parametrize("which", ROBOTS)
def test_tool_and_spheres_are_those_of_pinocchio(which):
    model = robot(which)
    stages = StageModel(model, 8, spheres_of(which))
    q = np.random.default_rng(0).uniform(-3.0, 3.0, (8, model.n))
    at = stages.at(q)
    for k in range(8):
        pose, jacobian = model.tool(q[k])
        np.testing.assert_allclose(at.tool.position[k], pose.position, atol=1e-12)
        np.testing.assert_allclose(at.tool.rotation[k], pose.rotation, atol=1e-12)
        np.testing.assert_allclose(at.tool.jacobian[k], jacobian, atol=1e-12)
        np.testing.assert_allclose(at.centers[k], sphere_centers(which, q[k]), atol=1e-12)


@pytest.mark.parametrize("which", ROBOTS)
def test_jacobians_are_those_of_differences(which):
    model = robot(which)
    stages = StageModel(model, 1, spheres_of(which))
    q = np.random.default_rng(1).uniform(-2.0, 2.0, model.n)
    at = stages.at(q[None])
    for joint in range(model.n):
        moved = [stages.at((q + s * STEP * np.eye(model.n)[joint])[None]) for s in (1, -1)]
        for (there, back), slope in (
            ([m.tool.position[0] for m in moved], at.tool.jacobian[0, :3, joint]),
            ([m.centers[0] for m in moved], at.slopes[0, :, joint].reshape(-1, 3)),
        ):
            np.testing.assert_allclose((there - back) / (2 * STEP), slope, atol=1e-8)
        there, back = (m.tool.rotation[0] for m in moved)
        turn = (there - back) / (2 * STEP) @ at.tool.rotation[0].T
        w = at.tool.jacobian[0, 3:, joint]
        skew = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        np.testing.assert_allclose(turn, skew, atol=1e-8)


def test_an_answer_does_not_change_with_the_next_call():
    model = robot()
    stages = StageModel(model, 2, spheres_of("ur10_ridgeback"))
    first = stages.at(np.zeros((2, model.n)))
    kept = (first.tool.position.copy(), first.slopes.copy())
    stages.at(np.ones((2, model.n)))
    np.testing.assert_array_equal(first.tool.position, kept[0])
    np.testing.assert_array_equal(first.slopes, kept[1])


def test_home_of_the_ur10_is_that_of_the_authors_to_a_millimetre():
    model = robot("ur10_ridgeback")
    q = model.home((0.0, 0.0, 0.0))
    assert model.n == 9
    np.testing.assert_allclose(q[3:] / np.pi, [0.5, -0.25, 0.5, -0.25, 0.5, 0.417], atol=1e-12)
    off = model.tool(q)[0].position - [1.48985, 0.17431, 0.705131]
    assert np.linalg.norm(off) < 1e-3


def test_the_tool_of_the_ur10_is_29_cm_before_its_flange():
    arm = robot("ur10_ridgeback").config
    assert arm.arm.mount.xyz == (0.27, 0.01, 0.6658)
    assert np.linalg.norm(arm.tool.xyz) == pytest.approx(0.29)
    assert arm.tool.parent == "tool0"


def test_a_sphere_that_is_not_there_is_refused():
    with pytest.raises(ModelError, match="robot robot: spheres: no entry 99"):
        StageModel(robot(), 2, (99,))
