"""T(40): the torques, their limits and their rate."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from lexstack_config.parts import home_of
from lexstack_sim.impedance import ImpedanceLoop
from support.scenario import resolved, team

PERIOD = 0.001
ARMS = np.r_[3:10, 13:20]
BASES = np.r_[0:3, 10:13]


@pytest.fixture
def home():
    return home_of(team(), resolved())


@pytest.fixture
def loop(home):
    loop = ImpedanceLoop(team(), PERIOD, np.zeros(team().n))
    loop.reset(home)
    return loop


def gravity(q):
    torques = []
    for robot, part in zip(team().robots, team().slices, strict=True):
        model = robot.pinocchio
        torques.append(pin.computeGeneralizedGravity(model, model.createData(), q[part]))
    return np.concatenate(torques)


def test_at_rest_it_holds_the_weight_of_the_arms(loop, home):
    np.testing.assert_allclose(loop.control, gravity(home), atol=1e-12)
    assert np.abs(loop.control[ARMS]).max() > 5.0
    still = np.zeros(home.size)
    loop.update(home, still, home, still)
    np.testing.assert_allclose(loop.control, gravity(home), atol=1e-12)


def test_torques_are_stiffness_damping_and_gravity(loop, home):
    rng = np.random.default_rng(0)
    v, v_star = 0.01 * rng.standard_normal((2, home.size))
    q_star = home + 1e-3 * rng.standard_normal(home.size)
    arm = resolved().robots["panda_summit"].arm
    stiffness, damping = np.tile(arm.stiffness, 2), np.tile(arm.damping, 2)
    wanted = gravity(home)
    wanted[ARMS] += stiffness * (q_star - home)[ARMS] + damping * (v_star - v)[ARMS]
    for _ in range(10):  # the torque rate takes its time
        loop.update(home, v, q_star, v_star)
    np.testing.assert_allclose(loop.control[ARMS], wanted[ARMS], atol=1e-12)
    np.testing.assert_array_equal(loop.control[BASES], v_star[BASES])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_torque_changes_by_at_most_its_rate(loop, home, side):
    arm = resolved().robots["panda_summit"].arm
    rate = np.tile(arm.torque_rate, 2)
    far, still = home + side * 0.05, np.zeros(home.size)
    fastest = 0.0
    for _ in range(40):
        before = loop.control.copy()
        loop.update(home, still, far, still)
        change = np.abs(loop.control - before)[ARMS] / PERIOD
        assert (change <= rate * (1.0 + 1e-9)).all()
        fastest = max(fastest, float((change / rate).max()))
    assert fastest > 0.999  # the limit was reached, so the test means something


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_torque_stays_within_its_limit(loop, home, side):
    limit = np.tile(resolved().robots["panda_summit"].arm.torque, 2)
    still = np.zeros(home.size)
    for _ in range(500):
        loop.update(home, still, home + side * 5.0, still)
    np.testing.assert_allclose(loop.control[ARMS], side * limit)
