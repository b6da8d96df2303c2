"""The paper's way (CasADi, sparse QP) takes the steps that the fast path takes."""

import numpy as np

from lexstack.mpc import Start
from lexstack_experiments.baselines.htmpc_paper import PaperHtmpc
from support.htmpc import config, optimiser, random_objectives, robot


def test_both_ways_give_the_same_inputs():
    own = config("authors")
    solver = optimiser(name="authors")
    paper = PaperHtmpc(robot(), own, ("ee_position", "base_position"), "osqp")
    for seed in range(4):
        rng = np.random.default_rng(seed)
        q = robot().home((0.0, 0.0, 0.0)) + rng.normal(0, 0.1, 9)
        start = Start(0.0, q, rng.normal(0, 0.05, 9))
        objectives = random_objectives(rng, start, solver, far=0.05)
        guess = solver.horizon.braking(start.v, robot().limits.acceleration)
        u, _ = paper.solve((start.q, start.v, np.zeros(9)), objectives, guess)
        plan = solver.solve(start, objectives)
        # OSQP's tolerance is 1e-6 of its own scale, not of the inputs.
        np.testing.assert_allclose(plan.u, u, atol=0.02)
        assert np.abs(plan.u).max() > 0.1
    assert paper.failures == 0
