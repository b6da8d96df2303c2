"""Limits as constraints: kept by every stage, from every state, and by the next solve too."""

import numpy as np
import pytest
from scipy.optimize import nnls

from lexstack.mpc import Start
from lexstack.mpc.condensed_qp import CondensedQp
from lexstack.mpc.hard_limits import SLACK, HardLimits
from lexstack.mpc.limited_qp import ActiveSet, LimitedQp
from support.htmpc import optimiser, random_objectives, random_start, robot


def kept(plan, start, slack=1e-7):
    """Return whether a plan keeps all limits that its start allows."""
    limits = robot().limits
    solver = optimiser()
    brake = solver.horizon.braking(start.v, limits.acceleration)
    q, v = solver.horizon.roll_out(start.q, start.v, brake)
    return (
        np.all(np.abs(plan.u) <= limits.acceleration + slack)
        and np.all(np.abs(plan.v[1:]) <= np.maximum(limits.velocity, np.abs(v[1:])) + slack)
        and np.all(plan.q[1:] <= np.maximum(limits.position_upper, q[1:]) + slack)
        and np.all(plan.q[1:] >= np.minimum(limits.position_lower, q[1:]) - slack)
    )


@pytest.mark.parametrize("wild", [1.0, 4.0])
def test_every_stage_keeps_the_limits_from_random_states(wild):
    solver = optimiser()
    rng = np.random.default_rng(int(wild))
    for _ in range(25):
        start = random_start(rng, wild=wild)
        plan = solver.solve(start, random_objectives(rng, start, solver, far=1.0))
        assert plan.solved
        assert kept(plan, start)


def test_in_closed_loop_no_limit_is_ever_left():
    """The last row lets a joint stop after the horizon: what was kept can be kept again."""
    solver = optimiser(horizon=3)  # too short to stop in: 0.3 s, at 2 rad/s and 2.16 rad/s2
    limits = robot().limits
    rng = np.random.default_rng(1)
    start = random_start(rng, wild=0.5)
    edge = np.where(np.isfinite(limits.position_upper), limits.position_upper - 2.0, start.q)
    q, v, plan = edge, np.zeros(9), None
    tool = robot().tool(np.where(np.isfinite(limits.position_upper), edge + 1.9, q))[0].position
    for k in range(80):
        objectives = random_objectives(rng, Start(0.0, q, v), solver, far=2.0)
        objectives[0].reference[:] = tool + rng.normal(0, 1.0, 3)
        plan = solver.solve(Start(0.1 * k, q, v), objectives, plan)
        q, v = plan.q[1], plan.v[1]
        assert np.all(np.abs(plan.u[0]) <= limits.acceleration + 1e-7)
        assert np.all(np.abs(v) <= limits.velocity + 1e-7)
        assert np.all((q <= limits.position_upper + 1e-7) & (q >= limits.position_lower - 1e-7))


def test_rows_are_those_of_differences():
    solver = optimiser()
    rows = HardLimits(robot().limits, solver.horizon)
    rng = np.random.default_rng(2)
    q, v, u = rng.normal(size=9), rng.normal(size=9), rng.normal(size=(10, 9))
    places = np.array(np.nonzero(np.ones((31, 9))))
    d = rng.normal(size=u.shape)
    change = rows.values(q, v, u + d) - rows.values(q, v, u)
    np.testing.assert_allclose(
        rows.rows(places) @ d.ravel(), change[places[0], places[1]], atol=1e-10
    )


def test_limits_by_need_give_the_optimum_of_all_limits():
    """Only broken limits enter the QP; the answer must be that of the QP with every row."""
    solver = optimiser()
    rng = np.random.default_rng(4)
    every_place = np.array(np.nonzero(np.ones((31, 9))))
    all_of_them = ActiveSet(np.zeros(0), every_place, np.zeros(every_place.shape[1]))
    for _ in range(10):
        start = random_start(rng, wild=2.0)
        hard = HardLimits(robot().limits, solver.horizon).at(start.q, start.v)
        u = hard.repaired(rng.normal(size=(10, 9)))
        root = rng.normal(size=(90, 90))
        hessian = root @ root.T + np.eye(90)
        gradient = 30.0 * rng.normal(size=90)
        none = (np.zeros((0, 90)), np.zeros(0), np.zeros(0))
        by_need = LimitedQp(CondensedQp(hessian.copy()), gradient, none[0])
        by_need.within(hard, u)
        found, word = by_need.solve(none[1], none[2])
        every = LimitedQp(CondensedQp(hessian.copy()), gradient, none[0], None, all_of_them)
        every.within(hard, u)
        best, again = every.solve(none[1], none[2])
        assert word == again == "solved"
        assert by_need.places.shape[1] < every.places.shape[1]
        np.testing.assert_allclose(found, best, atol=1e-6)
        _check_optimal(hessian, gradient, found, hard, u)


def _check_optimal(hessian, gradient, d, hard, u):
    """Check the Karush-Kuhn-Tucker conditions by a bounded least-squares fit of multipliers."""
    assert not hard.violated(u + d.reshape(u.shape)).size
    values = hard.values(u + d.reshape(u.shape))
    at_upper = np.array(np.nonzero(values > hard.upper - 1e-6))
    at_lower = np.array(np.nonzero(values < hard.lower + 1e-6))
    normals = np.concatenate((hard.rows(at_upper), -hard.rows(at_lower)))
    slope = hessian @ d + gradient
    left = nnls(normals.T, -slope)[1] if len(normals) else np.linalg.norm(slope)
    assert left < 1e-4 * max(1.0, np.linalg.norm(gradient))


def test_a_guess_that_breaks_a_limit_brakes_instead():
    solver = optimiser()
    start = Start(0.0, robot().home((0.0, 0.0, 0.0)), np.zeros(9))
    hard = HardLimits(robot().limits, solver.horizon).at(start.q, start.v)
    u = np.zeros((10, 9))
    u[:, 4] = 100.0
    repaired = hard.repaired(u)
    assert not hard.violated(repaired).size
    np.testing.assert_array_equal(repaired[:, :4], 0.0)
    assert SLACK < 1e-6
