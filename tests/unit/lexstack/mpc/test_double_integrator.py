"""The condensed double integrator is the step-by-step one, and braking brakes."""

import numpy as np
import pytest

from lexstack.mpc import Horizon
from lexstack.mpc.effort import Effort
from support.htmpc import config


@pytest.mark.parametrize("stages", [2, 10, 30])
def test_condensed_and_step_by_step_agree(stages):
    rng = np.random.default_rng(stages)
    horizon = Horizon(stages, 0.1)
    q, v = rng.normal(size=9), rng.normal(size=9)
    u = rng.normal(size=(stages, 9))
    positions, velocities = horizon.roll_out(q, v, u)
    for k in range(stages + 1):
        np.testing.assert_allclose(positions[k], q, atol=1e-12)
        np.testing.assert_allclose(velocities[k], v, atol=1e-12)
        if k < stages:
            q = q + 0.1 * v + 0.5 * 0.01 * u[k]
            v = v + 0.1 * u[k]


def test_braking_stops_at_the_limit_and_stays():
    horizon = Horizon(10, 0.1)
    v, limit = np.array([1.0, -0.25, 0.0, 3.0]), np.array([2.0, 1.0, 1.0, 2.0])
    u = horizon.braking(v, limit)
    assert np.all(np.abs(u) <= limit + 1e-12)
    velocities = horizon.roll_out(np.zeros(4), v, u)[1]
    np.testing.assert_allclose(velocities[-1], [0.0, 0.0, 0.0, 1.0], atol=1e-12)
    assert np.all(velocities * np.sign(v) >= -1e-12)


def test_effort_slopes_are_those_of_differences_and_remember_the_input_before():
    rng = np.random.default_rng(3)
    horizon = Horizon(6, 0.1)
    effort = Effort(config(effort=config().effort).effort, horizon, 9)
    v0, u, previous = rng.normal(size=9), rng.normal(size=(6, 9)), rng.normal(size=9)

    def value(inputs):
        return effort.value(horizon.roll_out(np.zeros(9), v0, inputs)[1][1:], inputs, previous)

    v = horizon.roll_out(np.zeros(9), v0, u)[1][1:]
    gradient = effort.gradient(v, u, previous)
    for _ in range(20):
        d = rng.normal(size=u.shape)
        # The cost is quadratic, so central differences are exact but for rounding.
        slope = (value(u + 1e-3 * d) - value(u - 1e-3 * d)) / 2e-3
        assert slope == pytest.approx(np.vdot(gradient, d), rel=1e-8)
        curve = (value(u + d) - 2 * value(u) + value(u - d)) / 2
        hessian = np.einsum("ia,ija,ja->", d, effort.hessian, d) / 2
        assert curve == pytest.approx(hessian, rel=1e-8)
    base = np.arange(9) < 3
    moved = effort.gradient(v, u, np.zeros(9))[0] - gradient[0]
    np.testing.assert_allclose(moved[base], config().effort.base_change * previous[base])
