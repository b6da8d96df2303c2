"""The MPC of a differential base: G(q) rolled out, exact derivatives, parking, oracle."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest

from lexstack.mpc import (
    COLUMNS,
    DEFAULT_HTMPC,
    CollisionScene,
    Htmpc,
    Objective,
    Start,
    Task,
)
from lexstack.mpc.unicycle_horizon import UnicycleHorizon, driven
from lexstack.mpc.unicycle_lead import UnicycleLead
from lexstack_experiments.baselines.htmpc_casadi import stepped
from lexstack_experiments.baselines.htmpc_oracle import HtmpcOracle
from support.differential import driven as on_wheels
from support.differential import random_q

N, STEP, H = 10, 0.1, 1e-6


@cache
def robot(name="ur10"):
    return on_wheels(name)


def some_motion(seed, name="ur10", stages=N):
    """Return a state, and inputs that turn the base by up to a radian in a stage."""
    rng, model = np.random.default_rng(seed), robot(name)
    v = rng.uniform(-1.0, 1.0, model.n) * np.array([1.0, 3.0, *np.full(model.n - 2, 0.5)])
    return random_q(model, rng), v, rng.uniform(-2.0, 2.0, (stages, model.n))


def test_without_inputs_the_base_drives_along_the_arc_of_integrate():
    model, horizon = robot(), UnicycleHorizon(N, STEP)
    for seed in range(20):
        q, v, u = some_motion(seed)
        positions, velocities = horizon.roll_out(q, v, np.zeros_like(u))
        np.testing.assert_array_equal(velocities, np.tile(v, (N + 1, 1)))
        for k in range(N + 1):
            np.testing.assert_allclose(positions[k], model.integrate(q, v, k * STEP), atol=1e-11)


def test_with_inputs_it_goes_where_many_short_arcs_lead():
    model, horizon = robot(), UnicycleHorizon(3, STEP)
    for seed in range(5):
        q, v, u = some_motion(seed, stages=3)
        end = horizon.roll_out(q, v, u)[0][-1]
        parts = 2000
        for stage in range(3):
            for _ in range(parts):
                dt = STEP / parts
                q = model.integrate(q, v + 0.5 * dt * u[stage], dt)
                v = v + dt * u[stage]
        np.testing.assert_allclose(end, q, atol=1e-8)


def test_a_plan_is_sampled_as_it_was_rolled_out():
    horizon = UnicycleHorizon(N, STEP)
    q, v, u = some_motion(3)
    positions, velocities = horizon.roll_out(q, v, u)
    for k in range(N):
        whole = driven(positions[k], velocities[k], u[k], STEP)
        np.testing.assert_allclose(whole, positions[k + 1], atol=1e-13)
        half = driven(positions[k], velocities[k], u[k], 0.5 * STEP)
        again = driven(half, velocities[k] + 0.5 * STEP * u[k], u[k], 0.5 * STEP)
        np.testing.assert_allclose(again, whole, atol=1e-12)


def whole_sensitivity(horizon, q, v, u):
    """Return dq_k/du of the horizon as one matrix, shape (N (n + 1), N n)."""
    slopes = np.broadcast_to(np.eye(len(q)), (len(u), len(q), len(q)))
    return horizon.sensitivity(q, v, u).rows(slopes)


def test_the_derivatives_are_those_of_differences_and_of_casadi():
    model, horizon = robot(), UnicycleHorizon(N, STEP)
    q, v, u = some_motion(1)
    ours = whole_sensitivity(horizon, q, v, u)
    symbol = ca.MX.sym("u", model.n, N)
    state, states = ca.DM(np.concatenate((q, v))), []
    for k in range(N):
        state = stepped(model, state, symbol[:, k], STEP)
        states.append(state[: model.nq])
    places = ca.vertcat(*states)
    function = ca.Function("f", [symbol], [places, ca.jacobian(places, ca.vec(symbol))])
    there, theirs = (value.full() for value in function(u.T))
    np.testing.assert_allclose(horizon.roll_out(q, v, u)[0][1:].ravel(), there.ravel(), atol=1e-11)
    np.testing.assert_allclose(ours, theirs, atol=1e-11)
    rng = np.random.default_rng(0)
    for _ in range(10):
        d = rng.normal(size=u.shape)
        ahead, back = (horizon.roll_out(q, v, u + s * H * d)[0][1:] for s in (1, -1))
        slope = (ahead - back).ravel() / (2 * H)
        np.testing.assert_allclose(ours @ d.ravel(), slope, atol=1e-7)


def test_gradient_and_curvature_are_sums_over_the_derivatives():
    model, horizon = robot(), UnicycleHorizon(N, STEP)
    rng = np.random.default_rng(2)
    q, v, u = some_motion(2)
    n, size = model.n, model.nq
    whole = whole_sensitivity(horizon, q, v, u)
    sensitivity = horizon.sensitivity(q, v, u)
    along = rng.normal(size=(N, size))
    np.testing.assert_allclose(
        sensitivity.gradient(along).ravel(), along.ravel() @ whole, atol=1e-11
    )
    root = rng.normal(size=(N, size, size))
    curved = root @ root.transpose(0, 2, 1)
    full = sensitivity.condensed(curved).reshape(N, N, n, n).transpose(0, 2, 1, 3)
    by_hand = sum(part.T @ curved[k] @ part for k, part in enumerate(whole.reshape(N, size, N * n)))
    np.testing.assert_allclose(full.reshape(N * n, N * n), by_hand, atol=1e-9)


@pytest.mark.parametrize("name", ["tiago", "tiago_dual", "pr2"])
@pytest.mark.parametrize("kind", sorted(COLUMNS))
def test_the_gradient_of_a_level_is_that_of_differences(name, kind):
    model = robot(name)
    own = replace(DEFAULT_HTMPC, horizon=4, hard_limits=False)
    solver = Htmpc(model, own)
    rng = np.random.default_rng(4)
    q, v, u = some_motion(4, name, 4)
    frame = "right" if kind.startswith("ee") and name != "tiago" else "tool"
    columns = COLUMNS[kind] or len(model.config.arm.joints)
    objective = Objective("t", kind, rng.normal(size=(4, columns)), frame=frame)
    task = Task(objective, own, model, UnicycleLead(model, own.step), (q, v))
    around = CollisionScene(q[:3] + rng.uniform(-1.5, 1.5, (4, 2, 3)), np.array([0.1, 0.2]))
    program = solver.program(Start(0.0, q, v), None, around, (frame,))
    quadratic = program.quadratic(program.iterate(u), task)
    np.testing.assert_allclose(quadratic.hessian, quadratic.hessian.T, atol=1e-8)
    for _ in range(5):
        d = rng.normal(size=u.shape)
        there, back = (program.cost(program.iterate(u + s * H * d), task) for s in (1, -1))
        slope = (there - back) / (2 * H)
        assert slope == pytest.approx(quadratic.gradient @ d.ravel(), rel=1e-4, abs=1e-3)
    light = Task(objective, own, model, UnicycleLead(model, own.step), (q, v))
    light.weights = 2.0 * task.weights
    part = program.quadratic(program.iterate(u), light).hessian - quadratic.hessian
    for _ in range(5):
        d = rng.normal(size=u.shape)
        there, back = (task.error(program.iterate(u + s * H * d).at) for s in (1, -1))
        turned = (there - back) / (2 * H)
        by_hand = np.vdot(task.weights * turned, turned)
        assert d.ravel() @ part @ d.ravel() == pytest.approx(by_hand, rel=1e-4)


def parked(solver, start, objectives, seconds, there):
    """Return q once ``there`` holds and the base rests, or after all the seconds; and the plans."""
    model, plan, plans = solver.robot, None, []
    q, v = start, np.zeros(model.n)
    for k in range(round(seconds / STEP)):
        plan = solver.solve(Start(k * STEP, q, v), objectives, plan)
        plans.append(plan)
        q, v, _ = plan.sample((k + 1) * STEP)
        if there(q) and np.abs(v[:2]).max() < 0.02:
            break
    return q, plans


POSE = np.array([0.4, -0.2, 0.7])


def base_error(q):
    return np.linalg.norm(q[:2] - POSE[:2]), abs(
        np.remainder(q[2] - POSE[2] + np.pi, 2 * np.pi) - np.pi
    )


def random_base(seed):
    """Return x, y, yaw up to 1.5 m away; of the first two the goal lies exactly at the side."""
    rng = np.random.default_rng(seed)
    if seed < 2:
        side = np.array([-np.sin(POSE[2]), np.cos(POSE[2])])
        return (*(POSE[:2] + (0.5, -1.0)[seed] * side), POSE[2])
    return (*(POSE[:2] + rng.uniform(-1.1, 1.1, 2)), rng.uniform(-np.pi, np.pi))


@pytest.mark.parametrize("seed", range(6))
def test_it_parks_within_a_centimetre(seed):
    model = robot()
    solver = Htmpc(model, DEFAULT_HTMPC, ())
    pose = (Objective("park", "base_pose", np.tile(POSE, (N, 1))),)
    q, plans = parked(
        solver, model.home(random_base(seed)), pose, 15.0, lambda q: max(base_error(q)) < 0.01
    )
    assert max(base_error(q)) < 0.01
    assert all(plan.solved for plan in plans)
    limits = model.limits
    for plan in plans:
        assert (np.abs(plan.u) <= limits.acceleration * (1.0 + 1e-6)).all()
        assert (np.abs(plan.v) <= limits.velocity * (1.0 + 1e-6)).all()


@pytest.mark.parametrize("seed", range(4))
def test_the_position_comes_before_the_yaw_where_it_is_the_first_level(seed):
    model = robot()
    solver = Htmpc(model, DEFAULT_HTMPC, ())
    levels = (
        Objective("there", "base_position", np.tile(POSE[:2], (N, 1))),
        Objective("park", "base_pose", np.tile(POSE, (N, 1))),
    )
    q, plans = parked(
        solver, model.home(random_base(seed)), levels, 20.0, lambda q: max(base_error(q)) < 0.01
    )
    assert max(base_error(q)) < 0.01
    assert all(plan.solved for plan in plans)


@pytest.mark.parametrize("seed", range(3))
def test_the_tool_is_held_while_the_base_parks(seed):
    model = robot()
    solver = Htmpc(model, DEFAULT_HTMPC, ())
    start = model.home(random_base(seed + 1))
    goal = np.array([POSE[0] + 0.6, POSE[1] + 0.4, 1.0])
    levels = (
        Objective("hold", "ee_position", np.tile(goal, (N, 1))),
        Objective("park", "base_pose", np.tile(POSE, (N, 1))),
    )
    reached = []

    def there(q):
        reached.append(np.linalg.norm(model.tool(q)[0].position - goal))
        return max(base_error(q)) < 0.01

    q, _ = parked(solver, start, levels, 20.0, there)
    assert max(base_error(q)) < 0.01
    first = next(k for k, apart in enumerate(reached) if apart < 0.005)
    assert max(reached[first:]) < 0.02, "delta is 10 mm"


def test_a_base_on_the_way_of_a_reference_that_moves_follows_it():
    """A circle of 1 m at 0.4 m/s, from 5 cm beside it."""
    model = robot()
    solver = Htmpc(model, DEFAULT_HTMPC, ())
    q, v, plan = model.home((1.05, 0.0, 0.5 * np.pi)), np.zeros(model.n), None
    apart = []
    for k in range(120):
        times = k * STEP + solver.horizon.times[1:]
        yaw = 0.4 * times
        circle = np.column_stack((np.cos(yaw), np.sin(yaw), yaw + 0.5 * np.pi))
        plan = solver.solve(Start(k * STEP, q, v), (Objective("o", "base_pose", circle),), plan)
        q, v, _ = plan.sample((k + 1) * STEP)
        now = 0.4 * (k + 1) * STEP
        apart.append(np.linalg.norm(q[:2] - [np.cos(now), np.sin(now)]))
    assert max(apart[60:]) < 0.03


@pytest.mark.slow
def test_both_levels_come_near_the_optimum_of_ipopt():
    """The same problem, base task led by the same motion: level 1 to 1e-8, level 2 within 3 %."""
    model = robot()
    own = replace(DEFAULT_HTMPC, iterations=60, early_stop_ratio=0.0, restart_from_previous=False)
    solver = Htmpc(model, own, ())
    kinds = ("ee_position", "base_pose")
    oracle = HtmpcOracle(model, own, kinds)
    lead = UnicycleLead(model, own.step)
    gaps, firsts = [], []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        q = model.home((0.0, 0.0, 0.0)) + rng.normal(0.0, 0.2, model.nq)
        v = rng.normal(0.0, 0.1, model.n)
        tool = model.tool(q)[0].position + rng.normal(0.0, 0.1, 3)
        goals = np.tile([*(q[:2] + rng.normal(0.0, 0.3, 2)), rng.normal()], (N, 1))
        objectives = (
            Objective("tool", "ee_position", np.tile(tool, (N, 1))),
            Objective("base", "base_pose", goals),
        )
        led = (objectives[0], replace(objectives[1], reference=lead.motion(q, v, goals)[0]))
        state = (q, v, np.zeros(model.n))
        best = oracle.solve(state, led, np.zeros((N, model.n)), 1.0)
        assert all(level.converged for level in best)
        start = Start(0.0, q, v)
        program = solver.program(start)
        tasks = [Task(objective, own, model) for objective in led]
        one = solver.solve(start, objectives[:1])
        mine = program.cost(program.iterate(one.u), tasks[0])
        firsts.append((mine - best[0].total) / max(1.0, abs(best[0].total)))
        two = solver.solve(start, objectives)
        ours = program.cost(program.iterate(two.u), tasks[1])
        begun = best[0].costs[1]
        gaps.append((ours - best[1].total) / (begun - best[1].total))
    assert max(firsts) < 1e-8
    assert max(gaps) < 0.03
