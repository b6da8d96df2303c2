"""Tasks of the MPC: errors, exact Jacobians, angles that wrap, references that are checked."""

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import COLUMNS, Objective, StageModel, Task
from lexstack.robots import from_quaternion, log3, to_quaternion
from lexstack.robots.spatial import from_quaternions, log3_all, log_slopes
from support.htmpc import config, robot

STAGES = config().horizon


def random_reference(kind, rng):
    return rng.normal(size=(STAGES, COLUMNS[kind] or 6))


@pytest.mark.parametrize("kind", sorted(COLUMNS))
def test_jacobians_of_errors_are_those_of_differences(kind):
    rng = np.random.default_rng(7)
    model = robot()
    stages = StageModel(model, STAGES)
    task = Task(Objective("t", kind, random_reference(kind, rng)), config(), model)
    q = rng.uniform(-2, 2, (STAGES, model.n))
    jacobian = task.jacobian(stages.at(q))
    for joint in range(model.n):
        h = 1e-6 * np.eye(model.n)[joint]
        slope = (task.error(stages.at(q + h)) - task.error(stages.at(q - h))) / 2e-6
        np.testing.assert_allclose(slope, jacobian[:, :, joint], atol=1e-6)


def test_yaw_goes_the_short_way():
    model = robot()
    q = np.zeros((STAGES, model.n))
    q[:, 2] = np.linspace(-20.0, 20.0, STAGES)
    reference = np.zeros((STAGES, 3))
    reference[:, 2] = 3.0
    task = Task(Objective("t", "base_pose", reference), config(), model)
    error = task.error(StageModel(model, STAGES).at(q))[:, 2]
    assert np.all((error > -np.pi) & (error <= np.pi))
    np.testing.assert_allclose(np.cos(error), np.cos(q[:, 2] - 3.0), atol=1e-12)
    np.testing.assert_allclose(np.sin(error), np.sin(q[:, 2] - 3.0), atol=1e-12)


def test_a_pose_error_is_zero_at_the_pose_and_ignores_the_sign_of_the_quaternion():
    model = robot()
    q = np.tile(model.home((0.3, 0.2, 0.1)), (STAGES, 1))
    pose = model.tool(q[0])[0]
    for sign in (1.0, -1.0):
        reference = np.tile([*pose.position, *(sign * to_quaternion(pose.rotation))], (STAGES, 1))
        task = Task(Objective("t", "ee_pose", reference), config(), model)
        np.testing.assert_allclose(task.error(StageModel(model, STAGES).at(q)), 0.0, atol=1e-9)


@pytest.mark.parametrize(
    "angle", [0.0, 1e-9, 1e-5, 1e-3, 1.0, 3.0, np.pi - 1e-3, np.pi - 1e-9, np.pi]
)
def test_logarithm_of_many_is_that_of_one(angle):
    rng = np.random.default_rng(2)
    axes = rng.normal(size=(6, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    quaternions = np.column_stack((np.sin(angle / 2) * axes, np.full(6, np.cos(angle / 2))))
    rotations = from_quaternions(quaternions)
    vectors = log3_all(rotations)
    for k in range(6):
        np.testing.assert_allclose(rotations[k], from_quaternion(quaternions[k]), atol=1e-14)
        np.testing.assert_allclose(vectors[k], log3(rotations[k]), atol=1e-9)
    assert np.isfinite(log_slopes(vectors)).all()


def test_costs_are_those_of_h8():
    rng = np.random.default_rng(4)
    own = config("authors")
    task = Task(Objective("t", "ee_position", np.zeros((STAGES, 3))), own, robot())
    error = rng.normal(size=(STAGES, 3))
    by_hand = 0.5 * (
        own.ee.stage * np.sum(error[:-1] ** 2) + own.ee.terminal * np.sum(error[-1] ** 2)
    )
    assert task.cost(error) == pytest.approx(by_hand)
    assert task.stage_costs(error).sum() == pytest.approx(by_hand)


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        (np.zeros((STAGES, 2)), "reference of shape"),
        (np.zeros((STAGES - 1, 3)), "reference of shape"),
        (np.full((STAGES, 3), np.nan), ".*expected finite numbers"),
    ],
)
def test_a_wrong_reference_is_named(reference, message):
    with pytest.raises(InputError, match=f"task reach: {message}"):
        Task(Objective("reach", "ee_position", reference), config(), robot())


def test_an_unknown_kind_is_named():
    with pytest.raises(InputError, match="task reach: kind 'wave'; known: ee_position"):
        Task(Objective("reach", "wave", np.zeros((STAGES, 3))), config(), robot())
