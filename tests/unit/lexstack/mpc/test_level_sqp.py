"""Levels, guards, line search and status: the traps of the method, each with its test."""

import dataclasses

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import Objective, Outcome, Start, Task, hold, steps
from lexstack.mpc import level_sqp as level_module
from lexstack.mpc.condensed_qp import CondensedQp
from lexstack.mpc.lexicographic_constraints import LexicographicConstraint
from lexstack.mpc.linear_rows import LinearRows
from support.htmpc import optimiser, random_objectives, random_start, robot

REST = np.zeros(9)


def standing(solver):
    """Return the home state at rest, and where its tool is."""
    q = robot().home((0.0, 0.0, 0.0))
    return Start(0.0, q, REST), robot().tool(q)[0].position


def hold_and_reach(solver, base=(0.5278, -1.9324)):
    """Return the objectives: hold the tool where it is, bring the base somewhere."""
    start, tool = standing(solver)
    stages = solver.config.horizon
    return start, (
        Objective("ee", "ee_position", np.tile(tool, (stages, 1))),
        Objective("base", "base_position", np.tile(base, (stages, 1))),
    )


def test_a_failed_qp_is_a_failed_level_and_not_a_step_of_zero(monkeypatch):
    """Trap: at home, at rest, the guess already tracks the tool perfectly."""
    solver = optimiser(qp="condensed")
    start, objectives = hold_and_reach(solver)
    fail = "iteration limit"

    def refuse(self, center, *_):
        return np.zeros(center.size), np.zeros(0), fail

    monkeypatch.setattr(CondensedQp, "solve", refuse)
    plan = solver.solve(start, objectives)
    assert not plan.solved
    assert plan.levels[0].outcome is Outcome.FAILED
    assert not plan.levels[0].succeeded
    assert plan.levels[0].qp == fail
    assert "failed" in plan.levels[0].text
    assert plan.levels[1].outcome is Outcome.SKIPPED
    assert not plan.levels[1].succeeded
    np.testing.assert_allclose(plan.errors[0], 0.0, atol=1e-9)


def test_what_is_not_finite_fails(monkeypatch):
    solver = optimiser()
    start, objectives = hold_and_reach(solver)
    monkeypatch.setattr(level_module.Program, "cost", lambda *_: float("nan"))
    plan = solver.solve(start, objectives)
    assert plan.levels[0].outcome is Outcome.FAILED
    assert "not finite" in plan.levels[0].qp


def test_at_its_optimum_a_level_has_converged_and_not_failed():
    solver = optimiser(iterations=30, early_stop_ratio=0.0, hard_limits=False)
    start, objectives = hold_and_reach(solver)
    plan = solver.solve(start, objectives[:1])
    assert plan.levels[0].outcome is Outcome.CONVERGED
    assert plan.levels[0].succeeded


def test_a_level_goes_on_while_its_task_gains_enough_and_no_longer():
    every = optimiser(iterations=10, early_stop_ratio=0.0)
    start, objectives = hold_and_reach(every)
    counts, gains = [], []
    for enough in (0.0, 0.01, 0.2, 1e9):
        plan = optimiser(iterations=10, early_stop_ratio=enough).solve(start, objectives)
        counts.append(plan.levels[1].iterations)
        gains.append(plan.levels[1].decrease)
    assert counts[0] == 10
    assert counts[0] > counts[1] > counts[2] > counts[3] == 1
    assert gains[0] >= gains[1] > gains[2] > gains[3] > 0.0


@pytest.mark.parametrize("correction", [False, True])
def test_without_tolerance_the_base_is_frozen_and_the_status_says_by_what(correction):
    """Trap: delta = 0 lets no step pass that leaves the tangent."""
    solver = optimiser(
        tolerance=0.0, second_order_correction=correction, restart_from_previous=False
    )
    start, objectives = hold_and_reach(solver)
    plan = solver.solve(start, objectives)
    status = plan.levels[1]
    assert status.outcome is Outcome.BLOCKED
    assert not status.succeeded
    assert plan.solved
    assert status.steps == (0.0,)
    assert status.trials == solver.config.line_search.trials
    assert status.blocked_by.startswith("level 1 ee, state ")
    loose = optimiser(
        tolerance=0.001, second_order_correction=correction, restart_from_previous=False
    )
    moved = loose.solve(start, objectives)
    assert moved.levels[1].outcome is Outcome.STEPPED
    assert np.linalg.norm(moved.q[-1, :2]) > 0.02


def test_the_tolerance_stands_in_the_line_search_and_nowhere_else():
    """Trap: in the QP and in the line search it would count twice."""
    solver = optimiser(tolerance=0.01, second_order_correction=False)
    _, objectives = hold_and_reach(solver)
    task = Task(objectives[0], solver.config, robot())
    for delta in (0.0, 0.01, 0.5):
        own = dataclasses.replace(
            solver.config, ee=dataclasses.replace(solver.config.ee, tolerance=delta)
        )
        task = Task(objectives[0], own, robot())
        best = np.full((10, 3), 0.02)
        constraint = LexicographicConstraint(0, task, best, "axis")
        np.testing.assert_array_equal(constraint.upper, 0.02)
        np.testing.assert_array_equal(constraint.lower, -0.02)
        assert constraint.excess(best + delta)[0] <= 1e-12
        assert constraint.excess(best + delta + 1e-6)[0] > 0.0
        assert constraint.excess(-best - delta - 1e-6)[0] > 0.0


@pytest.mark.parametrize("kind", ["axis", "stage", "sum"])
def test_rows_of_guards_are_those_of_differences(kind):
    solver = optimiser(hard_limits=False)
    rng = np.random.default_rng(9)
    start = random_start(rng)
    task = Task(random_objectives(rng, start, solver)[0], solver.config, robot())
    program = solver.program(start)
    u = rng.normal(size=(10, 9))
    at = program.iterate(u).at
    constraint = LexicographicConstraint(0, task, task.error(at), kind)
    sensitivity = solver.horizon.sensitivity(start.q, start.v, u)
    rows = LinearRows.of((constraint,), at, sensitivity, None, u.size).matrix
    for _ in range(10):
        d = rng.normal(size=u.shape)
        there, back = (
            constraint.value(task.error(program.iterate(u + s * 1e-6 * d).at)) for s in (1, -1)
        )
        np.testing.assert_allclose((there - back) / 2e-6, rows @ d.ravel(), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("kind", ["axis", "stage", "sum"])
def test_a_box_without_interior_is_no_obstacle(kind):
    """Trap: at e* = 0 the box of H(12) is a point. Every QP is solved all the same."""
    solver = optimiser(lexicographic=kind, second_order_correction=kind == "axis")
    start, objectives = hold_and_reach(solver)
    plan = None
    for k in range(20):
        now = Start(
            0.1 * k, start.q if plan is None else plan.q[1], REST if plan is None else plan.v[1]
        )
        plan = solver.solve(now, objectives, plan)
        assert all(status.qp == "solved" for status in plan.levels)


def test_the_input_before_is_remembered():
    """Trap: Delta u of the first stage counts from the input in force, not from zero."""
    solver = optimiser()
    start, objectives = hold_and_reach(solver)
    first = solver.solve(start, objectives)
    later = Start(0.1, first.q[1], first.v[1])
    np.testing.assert_array_equal(first.input_before(0.1), first.u[0])
    np.testing.assert_array_equal(first.input_before(0.15), first.u[1])
    np.testing.assert_array_equal(first.input_before(0.0), first.u[0])
    program = solver.program(later, first)
    forgetful = solver.program(later, None)
    u = first.shifted(0.1)
    base = solver.config.effort.base_change
    jump = 0.5 * base * (np.sum((u[0, :3] - first.u[0, :3]) ** 2) - np.sum(u[0, :3] ** 2))
    assert program.iterate(u).shared_cost - forgetful.iterate(u).shared_cost == pytest.approx(jump)


def test_the_plan_starts_from_the_measured_state():
    """Trap: inputs integrated open loop never meet the measured velocity again."""
    solver = optimiser()
    start, objectives = hold_and_reach(solver)
    plan = solver.solve(start, objectives)
    rng = np.random.default_rng(3)
    pushed = Start(0.1, plan.q[1] + rng.normal(0, 0.01, 9), plan.v[1] + rng.normal(0, 0.05, 9))
    again = solver.solve(pushed, objectives, plan)
    np.testing.assert_array_equal(again.q[0], pushed.q)
    np.testing.assert_array_equal(again.v[0], pushed.v)
    for time in (0.1, 0.13, 0.25):
        q, v, u = again.sample(time)
        stage = int((time - 0.1) / 0.1 + 1e-9)
        rest = time - 0.1 - 0.1 * stage
        np.testing.assert_allclose(v, again.v[stage] + rest * again.u[stage], atol=1e-12)
        np.testing.assert_allclose(
            q, again.q[stage] + rest * again.v[stage] + rest**2 / 2 * again.u[stage], atol=1e-12
        )
        np.testing.assert_array_equal(u, again.u[stage])


def test_a_jump_of_the_reference_is_not_interpolated_across():
    """Trap: the states before the jump see the old reference, those from it on the new one."""
    reference = steps(np.array([0.0, 0.35]), np.array([[0.0, 0.0], [2.0, 1.0]]))
    values = reference.at(0.1 * np.arange(1, 8))
    np.testing.assert_array_equal(values[:3], 0.0)
    np.testing.assert_array_equal(values[3:], np.tile([2.0, 1.0], (4, 1)))
    exactly = reference.at(np.array([0.35 - 1e-6, 0.35, 0.35 + 1e-6]))
    np.testing.assert_array_equal(exactly[:, 0], [0.0, 2.0, 2.0])


def test_the_tolerance_does_not_add_up_from_solve_to_solve():
    """Trap: e* + delta becomes the e* of the next solve, and so on."""
    for resume in (False, True):
        solver = optimiser(tolerance=0.002, restart_from_previous=resume)
        start, objectives = hold_and_reach(solver)
        q, v, plan, worst = start.q, start.v, None, []
        for k in range(250):
            plan = solver.solve(Start(0.1 * k, q, v), objectives, plan)
            q, v = plan.q[1], plan.v[1]
            worst.append(np.abs(plan.errors[0]).max())
        assert max(worst[-50:]) < 1.5 * 0.002, f"resume {resume}"


def test_joints_that_a_level_may_not_move_come_to_rest():
    solver = optimiser()
    start, (ee, base) = hold_and_reach(solver)
    moving = Start(0.0, start.q, np.array([0.3, -0.2, 0.1, 0.2, -0.2, 0.3, 0.1, 0.0, -0.1]))
    arm = solver.solve(moving, (dataclasses.replace(ee, moves="arm"),))
    np.testing.assert_allclose(arm.v[-1, :3], 0.0, atol=1e-12)
    assert np.abs(arm.u[:, 3:]).max() > 0.01
    only_base = solver.solve(moving, (dataclasses.replace(base, moves="base"),))
    np.testing.assert_allclose(only_base.v[-1, 3:], 0.0, atol=1e-12)
    assert np.linalg.norm(only_base.q[-1, :2] - base.reference[0]) < 1.75


def test_equal_input_gives_equal_bits_whatever_was_solved_in_between():
    solver = optimiser()
    start, objectives = hold_and_reach(solver)
    first = solver.solve(start, objectives)
    rng = np.random.default_rng(0)
    other = random_start(rng)
    solver.solve(other, random_objectives(rng, other, solver))
    again = solver.solve(start, objectives)
    np.testing.assert_array_equal(first.u, again.u)
    assert first.levels == again.levels


@pytest.mark.parametrize(
    ("q", "v"),
    [(np.zeros(8), np.zeros(9)), (np.full(9, np.nan), np.zeros(9)), (np.zeros(9), np.zeros(10))],
)
def test_a_state_that_cannot_be_is_named(q, v):
    with pytest.raises(InputError, match=r"htmpc: [qv] of shape .*, expected 9 finite numbers"):
        optimiser().solve(Start(0.0, q, v), hold_and_reach(optimiser())[1])


def test_no_task_at_all_is_refused():
    start, _ = standing(optimiser())
    with pytest.raises(InputError, match="at least one task"):
        optimiser().solve(start, ())


def test_a_plan_is_shifted_by_stages_and_parts_of_stages():
    solver = optimiser()
    start, objectives = hold_and_reach(solver)
    plan = solver.solve(start, objectives)
    np.testing.assert_array_equal(plan.shifted(0.0), plan.u)
    np.testing.assert_array_equal(plan.shifted(0.2)[:8], plan.u[2:])
    np.testing.assert_array_equal(plan.shifted(0.2)[8:], 0.0)
    np.testing.assert_array_equal(plan.shifted(50.0), np.zeros_like(plan.u))
    _, v, _ = plan.sample(0.05)
    velocities = solver.horizon.roll_out(REST, v, plan.shifted(0.05))[1]
    for k in range(9):
        np.testing.assert_allclose(velocities[k], plan.sample(0.05 + 0.1 * k)[1], atol=1e-12)


def test_a_waypoint_is_held_at_every_time():
    np.testing.assert_array_equal(
        hold(np.array([1.0, 2.0])).at(np.array([-1.0, 0.0, 9.0]))[:, 1], 2.0
    )
