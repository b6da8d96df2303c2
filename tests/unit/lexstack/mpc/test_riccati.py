"""The scalar Riccati recursion of a joint against dense matrices."""

import numpy as np
import pytest

from lexstack.mpc import Horizon
from lexstack.mpc.kernel import riccati
from lexstack.mpc.kernel.values import Gains, Weights

STAGES, JOINTS, DT = 7, 3, 0.1


def plain(function):
    """Return the loops as Python, uncompiled."""
    return getattr(function, "py_func", function)


@pytest.fixture
def problem():
    """Return random weights, kappa, which inputs are fixed, and every joint's B."""
    rng = np.random.default_rng(2)
    inputs, velocities, positions = rng.uniform(0.01, 2.0, (3, STAGES, JOINTS))
    last, change, kappa = rng.uniform(0.1, 1.0, (3, JOINTS))
    change[1] = 0.0
    fixed = np.zeros((STAGES, JOINTS), dtype=bool)
    fixed[:2, 2] = True
    horizon = Horizon(STAGES, DT)
    velocity, position, differences = horizon.to_velocity, horizon.to_position, horizon.change
    blocks = []
    for j in range(JOINTS):
        end = position[-1] + kappa[j] * velocity[-1]
        blocks.append(
            np.diag(inputs[:, j])
            + velocity.T @ (velocities[:, j, None] * velocity)
            + position.T @ (positions[:, j, None] * position)
            + last[j] * np.outer(end, end)
            + change[j] * differences.T @ differences
        )
    gains = Gains(np.empty((3, STAGES, JOINTS)), np.empty((STAGES, JOINTS)))
    weights = Weights(inputs, velocities, positions, last, change)
    plain(riccati.factor)(DT, kappa, weights, fixed, gains)
    return horizon, gains, fixed, blocks


def inverse_of(block, fixed):
    """Return B^-1 over the inputs that are not fixed, 0 elsewhere."""
    inverse = np.zeros_like(block)
    free = np.flatnonzero(~fixed)
    inverse[np.ix_(free, free)] = np.linalg.inv(block[np.ix_(free, free)])
    return inverse


def test_responses_are_those_of_the_inverse(problem):
    horizon, gains, fixed, blocks = problem
    force = np.random.default_rng(3).normal(size=(3, STAGES, JOINTS))
    motion = np.empty_like(force)
    plain(riccati.respond)(DT, gains, force, motion)
    alone = np.empty((3, STAGES))
    for j in range(JOINTS):
        right = force[0, :, j] + horizon.to_velocity.T @ force[1, :, j]
        right += horizon.to_position.T @ force[2, :, j]
        u = inverse_of(blocks[j], fixed[:, j]) @ right
        np.testing.assert_allclose(motion[0, :, j], u, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(motion[1, :, j], horizon.to_velocity @ u, atol=1e-11)
        np.testing.assert_allclose(motion[2, :, j], horizon.to_position @ u, atol=1e-11)
        plain(riccati.respond_joint)(DT, gains, np.ascontiguousarray(force[:, :, j]), alone, j)
        np.testing.assert_array_equal(alone, motion[:, :, j])


def test_covariances_are_those_of_the_positions(problem):
    horizon, gains, fixed, blocks = problem
    result = np.empty((STAGES, STAGES, JOINTS))
    plain(riccati.covariances)(DT, gains, result)
    for j in range(JOINTS):
        inverse = inverse_of(blocks[j], fixed[:, j])
        expected = horizon.to_position @ inverse @ horizon.to_position.T
        np.testing.assert_allclose(result[:, :, j], expected, rtol=1e-9, atol=1e-13)
