"""Others on the same problem of the MPC: the same step, from the same state."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack.mpc import Objective
from lexstack.robots import RobotModel
from lexstack_config.resolved import load_htmpc, load_robot
from lexstack_experiments.baselines.htmpc_hpipm import HpipmHtmpc
from lexstack_experiments.baselines.htmpc_paper import PaperHtmpc
from lexstack_experiments.benches.htmpc_peers import braking
from support.scenario import CONFIG

KIND = "ee_position"


@pytest.fixture(scope="module")
def problem():
    """Return robot, parameters with changes of all joints, a moving state and a goal."""
    robot = RobotModel("robot", load_robot(CONFIG / "robots/ur10_ridgeback.yaml"))
    config = load_htmpc(CONFIG / "htmpc/authors.yaml")
    effort = replace(config.effort, arm_change=0.05)
    rng = np.random.default_rng(0)
    q, v, last = (scale * rng.normal(size=robot.n) for scale in (0.1, 0.1, 0.2))
    q = q + robot.home((0.0, 0.0, 0.0))
    goal = robot.tool(q)[0].position + np.array([0.4, 0.2, -0.1])
    objective = Objective("tool", KIND, np.tile(goal, (config.horizon, 1)))
    return robot, replace(config, effort=effort), (q, v, last), objective


def test_hpipm_takes_the_step_of_the_paper_s_way(problem):
    robot, config, start, objective = problem
    others = [PaperHtmpc(robot, config, (KIND,), "osqp"), HpipmHtmpc(robot, config, KIND)]
    guess = braking(start[1], robot.limits.acceleration, config)
    osqp, hpipm = (solver.solve(start, (objective,), guess)[0] for solver in others)
    np.testing.assert_allclose(hpipm, osqp, atol=1e-6)
    costs = [others[0].cost(start, (objective,), u) for u in (guess, hpipm)]
    assert costs[1] < 0.9 * costs[0]
    assert [solver.failures for solver in others] == [0, 0]
    assert others[1].qp_seconds > 0.0


def test_braking_stops_within_the_limits(problem):
    robot, config, _, _ = problem
    limits = robot.limits.acceleration
    v = np.linspace(-1.0, 1.0, robot.n) * limits * 0.35
    inputs = braking(v, limits, config)
    assert (np.abs(inputs) <= limits).all()
    np.testing.assert_allclose(v + config.step * inputs.sum(axis=0), 0.0, atol=1e-12)
