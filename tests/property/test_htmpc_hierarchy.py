"""Properties of the HTMPC over random states, tasks and infeasible starts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.mpc import Outcome, Task
from lexstack.mpc.lexicographic_constraints import LexicographicConstraint
from support.htmpc import ROBOTS, optimiser, random_objectives, random_start

SEEDS = st.integers(0, 2**31 - 1)
MANY = settings(max_examples=40, derandomize=True, deadline=None)


def problem(seed, which="ur10_ridgeback", wild=1.0, **changes):
    """Return an optimiser, a random start and two random tasks."""
    solver = optimiser(which, **changes)
    rng = np.random.default_rng(seed)
    start = random_start(rng, which, wild=wild)
    return solver, start, random_objectives(rng, start, solver, far=rng.choice([0.05, 0.5, 3.0]))


def errors_at(solver, start, plan, objective):
    """Return a task's errors at a plan, and the task."""
    task = Task(objective, solver.config, solver.robot)
    return task.error(solver.program(start).iterate(plan.u).at), task


@pytest.mark.parametrize("which", ROBOTS)
@pytest.mark.parametrize("kind", ["axis", "stage", "sum"])
@MANY
@given(seed=SEEDS, wild=st.sampled_from([0.5, 1.0, 3.0]))
def test_a_lower_level_never_worsens_one_above_beyond_h13(which, kind, seed, wild):
    solver, start, objectives = problem(
        seed,
        which,
        wild,
        lexicographic=kind,
        second_order_correction=kind == "axis",
        tolerance=0.005,
    )
    alone = solver.solve(start, objectives[:1])
    both = solver.solve(start, objectives)
    assert alone.solved
    assert both.solved
    assert both.levels[0] == alone.levels[0], "the first level does not know the second"
    best, task = errors_at(solver, start, alone, objectives[0])
    final, _ = errors_at(solver, start, both, objectives[0])
    if kind == "axis":
        assert np.all(np.abs(final) <= np.abs(best) + 0.005 + 1e-9)
    elif kind == "stage":
        allowed = task.stage_costs(best) + task.stage_tolerance
        assert np.all(task.stage_costs(final) <= allowed * (1 + 1e-9) + 1e-12)
    else:
        allowed = task.cost(best) + task.stage_tolerance.sum()
        assert task.cost(final) <= allowed * (1 + 1e-9) + 1e-12


@MANY
@given(seed=SEEDS, wild=st.sampled_from([1.0, 3.0]), second_order_correction=st.booleans())
def test_without_tolerance_no_error_of_a_level_above_grows(seed, wild, second_order_correction):
    """With delta = 0 a level may move others only where it leaves every error as it is."""
    solver, start, objectives = problem(
        seed, wild=wild, tolerance=0.0, second_order_correction=second_order_correction
    )
    alone = solver.solve(start, objectives[:1])
    both = solver.solve(start, objectives)
    best, _ = errors_at(solver, start, alone, objectives[0])
    final, _ = errors_at(solver, start, both, objectives[0])
    assert np.all(np.abs(final) <= np.abs(best) + 1e-9)


@MANY
@given(seed=SEEDS, iterations=st.integers(1, 4))
def test_three_levels_guard_each_other(seed, iterations):
    solver, start, (ee, base) = problem(seed, iterations=iterations, tolerance=0.003)
    rng = np.random.default_rng(seed)
    third = random_objectives(rng, start, solver, far=1.0)[1]
    levels = (ee, base, third)
    plans = [solver.solve(start, levels[: count + 1]) for count in range(3)]
    tolerance = {"ee": 0.003, "base": solver.config.base.tolerance}
    for above in range(2):
        best, _ = errors_at(solver, start, plans[above], levels[above])
        for below in range(above + 1, 3):
            final, _ = errors_at(solver, start, plans[below], levels[above])
            allowed = np.abs(best) + tolerance[levels[above].name]
            assert np.all(np.abs(final) <= allowed + 1e-9)


@MANY
@given(seed=SEEDS, wild=st.sampled_from([1.0, 3.0]))
def test_every_step_lowers_the_cost_and_statuses_tell_the_truth(seed, wild):
    solver, start, objectives = problem(seed, wild=wild, iterations=3)
    plan = solver.solve(start, objectives)
    for status, error, objective in zip(plan.levels, plan.errors, objectives, strict=True):
        assert status.decrease >= -1e-12
        assert len(status.steps) == status.iterations
        assert all(0.0 <= step <= 1.0 for step in status.steps)
        assert status.qp == "solved"
        if status.outcome is Outcome.BLOCKED:
            assert set(status.steps) == {0.0}
            assert status.blocked_by
        if status.outcome is Outcome.STEPPED:
            assert any(step > 0.0 for step in status.steps)
        assert np.isfinite(error).all()
        assert status.name == objective.name


@MANY
@given(seed=SEEDS, wild=st.sampled_from([1.0, 5.0]))
def test_hard_limits_hold_at_every_stage(seed, wild):
    """Where the start is beyond a limit, nothing goes further than the hardest braking does."""
    solver, start, objectives = problem(seed, wild=wild)
    plan = solver.solve(start, objectives)
    limits = solver.robot.limits
    brake = solver.horizon.braking(start.v, limits.acceleration)
    q, v = solver.horizon.roll_out(start.q, start.v, brake)
    assert np.all(np.abs(plan.u) <= limits.acceleration + 1e-7)
    assert np.all(np.abs(plan.v) <= np.maximum(limits.velocity, np.abs(v)) + 1e-7)
    assert np.all(plan.q <= np.maximum(limits.position_upper, q) + 1e-7)
    assert np.all(plan.q >= np.minimum(limits.position_lower, q) - 1e-7)
    inside = np.all((q <= limits.position_upper) & (q >= limits.position_lower), axis=0)
    inside &= (np.abs(start.v) <= limits.velocity) & (v[-1] == 0.0)
    last = plan.q[-1] + np.sign(plan.v[-1]) * plan.v[-1] ** 2 / (2 * limits.acceleration)
    assert np.all(last[inside] <= limits.position_upper[inside] + 1e-6)
    assert np.all(last[inside] >= limits.position_lower[inside] - 1e-6)


@MANY
@given(seed=SEEDS, delta=st.floats(0.0, 0.1), kind=st.sampled_from(["axis", "stage", "sum"]))
def test_a_guard_lets_pass_what_it_was_made_from_and_no_worse(seed, delta, kind):
    solver = optimiser(lexicographic=kind, second_order_correction=False, tolerance=delta)
    rng = np.random.default_rng(seed)
    objective = random_objectives(rng, random_start(rng), solver)[0]
    task = Task(objective, solver.config, solver.robot)
    best = rng.normal(0.0, 0.1, (10, 3))
    constraint = LexicographicConstraint(0, task, best, kind)
    assert constraint.excess(best)[0] <= 0.0
    assert constraint.excess(0.5 * best)[0] <= 0.0
    worse = best + np.sign(best) * (delta + 1e-3) * 6.0
    excess, where = constraint.excess(worse)
    assert excess > 0.0
    assert where.startswith("level 1 ee")
