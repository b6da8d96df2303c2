"""QPs by their structure against the condensed QP and against quadprog on all rows at once."""

import dataclasses

import numpy as np
import pytest
import quadprog

from lexstack.mpc import Objective, Outcome, structured_qp
from lexstack.mpc import level_sqp as level_module
from lexstack.mpc.limited_qp import condensed_qp
from lexstack.mpc.structured_qp import StructuredQp
from support.htmpc import ROBOTS, optimiser, random_objectives, random_start, robot

KINDS = ("axis", "stage", "sum")


def levels(rng, which, solver, start, kind):
    """Return windows of tasks: three levels, masks, and poses and joints where h is by axis."""
    far = rng.choice([0.05, 0.5, 3.0])
    ee, base = random_objectives(rng, start, solver, far=far)
    third = random_objectives(rng, start, solver, far=1.0)[1]
    yield ee, base, third
    if kind != "axis":
        return
    tool = robot(which).tool(start.q)[0].position + rng.normal(0.0, 0.3, 3)
    turn = rng.normal(size=4)
    turn /= np.linalg.norm(turn)
    pose = Objective("pose", "ee_pose", np.tile(np.concatenate((tool, turn)), (10, 1)))
    near = start.q[3:] + rng.normal(0.0, 0.3, start.q.size - 3)
    joints = Objective("joints", "joint_positions", np.tile(near, (10, 1)))
    yield dataclasses.replace(ee, moves="arm"), base
    yield dataclasses.replace(base, moves="base"), ee
    yield pose, base, joints
    yield base, pose
    yield joints, ee, base


def problems(monkeypatch, which, kind, wild, seeds):
    """Return the arguments of all QPs of some solves."""
    found = []
    usual = level_module.structured_qp

    def noted(*arguments):
        found.append(arguments)
        return usual(*arguments)

    monkeypatch.setattr(level_module, "structured_qp", noted)
    solver = optimiser(
        which, lexicographic=kind, second_order_correction=kind == "axis", tolerance=0.005
    )
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        start = random_start(rng, which, wild=wild)
        for window in levels(rng, which, solver, start, kind):
            solver.solve(start, window)
    return found


def cost(quadratic, d):
    return quadratic.gradient @ d + 0.5 * d @ quadratic.hessian @ d


def excess(rows, hard, u, d, bent):
    """Return by how much a bound is exceeded at most, of all rows."""
    worst = 0.0
    if rows is not None and rows.lower.size:
        change = rows.matrix @ d
        lower, upper = rows.lower - bent, rows.upper - bent
        worst = max(worst, (change - upper).max(), (lower - change).max())
    if hard is None:
        return worst
    before = hard.values(u)
    change = hard.values(u + d.reshape(u.shape)) - before
    low, high = np.minimum(hard.lower - before, 0.0), np.maximum(hard.upper - before, 0.0)
    return max(worst, (change - high).max(), (low - change).max())


@pytest.mark.parametrize("which", ROBOTS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("wild", [1.0, 3.0])
@pytest.mark.parametrize("most", [None, 0])
def test_a_solution_costs_what_the_condensed_one_does(monkeypatch, which, kind, wild, most):
    """With ``most`` = 0 the interior point method solves all that a bound touches."""
    found = problems(monkeypatch, which, kind, wild, 6)
    left = compared = 0
    for quadratic, rows, hard, u, first in found:
        qp = StructuredQp(quadratic, rows, hard, u, first, most)
        d, word = qp.solve(rows.lower, rows.upper)
        left += qp.left
        assert word == "solved"
        if qp.left:
            continue
        assert excess(rows, hard, u, d, 0.0) < 2.2e-8, "the interior point method's rows"
        assert excess(None, hard, u, d, 0.0) < 2e-9, "limits"
        other = condensed_qp(quadratic, rows, hard, u, first)[0].solve(rows.lower, rows.upper)
        # Multipliers of 1e5 and more make a gain of what the condensed one exceeds a bound by.
        if other[1] == "solved" and excess(rows, hard, u, other[0], 0.0) < 1e-12:
            least = cost(quadratic, other[0])
            assert cost(quadratic, d) <= least + 1e-7 * abs(least) + 1e-7
            compared += 1
    assert compared > 0.7 * len(found) - left
    assert left <= 0.1 * len(found), "states, poses and joints at random: the hardest there are"


@pytest.mark.parametrize("which", ROBOTS)
def test_the_nearest_step_is_that_of_the_condensed_qp(monkeypatch, which):
    rng = np.random.default_rng(4)
    compared = 0
    for quadratic, rows, hard, u, first in problems(monkeypatch, which, "axis", 1.0, 4):
        if not rows.lower.size:
            continue
        qp = StructuredQp(quadratic, rows, hard, u, first)
        other = condensed_qp(quadratic, rows, hard, u, first)[0]
        d, _ = qp.solve(rows.lower, rows.upper)
        other.solve(rows.lower, rows.upper)
        np.testing.assert_allclose(qp.along(d), rows.matrix @ d, atol=1e-12)
        bent = rng.uniform(0.0, 0.2) * rows.matrix @ d  # then a shorter step is allowed
        near, word = qp.nearest(d, rows.lower - bent, rows.upper - bent)
        expected, again = other.nearest(d, rows.lower - bent, rows.upper - bent)
        # As above: multipliers of 1e5 make a cost of 1e-11 m.
        if qp.left or again != "solved" or excess(rows, hard, u, expected, bent) > 1e-11:
            continue
        assert word == "solved"
        compared += 1
        hessian = quadratic.hessian
        least = (expected - d) @ hessian @ (expected - d)
        assert (near - d) @ hessian @ (near - d) <= least * (1.0 + 1e-7) + 1e-7
        assert excess(rows, hard, u, near, bent) < 2.2e-8
    assert compared > 10


@pytest.mark.parametrize("which", ROBOTS)
def test_it_is_the_optimum_over_all_rows_by_quadprog(monkeypatch, which):
    """All limits and constraints at once, by a method that knows nothing of ours."""
    compared = 0
    for quadratic, rows, hard, u, first in problems(monkeypatch, which, "axis", 0.5, 3):
        every = np.array(np.nonzero(np.ones_like(hard.lower)))
        before = hard.values(u)
        low = np.minimum(hard.lower - before, 0.0)[tuple(every)]
        high = np.maximum(hard.upper - before, 0.0)[tuple(every)]
        moving = 1.0 if rows.moving is None else np.tile(rows.moving, len(u))
        limits = hard.rows(every) * moving
        matrix = np.concatenate((limits, -limits, rows.matrix, -rows.matrix))
        bounds = np.concatenate((low, -high, rows.lower, -rows.upper))
        real = np.isfinite(bounds) & (np.abs(matrix).max(axis=1) > 0.0)
        try:
            expected = quadprog.solve_qp(
                quadratic.hessian, -quadratic.gradient, matrix[real].T, bounds[real]
            )[0]
        except ValueError:
            continue  # rows that depend on each other and leave no room are too much for it
        qp = StructuredQp(quadratic, rows, hard, u, first)
        d, _ = qp.solve(rows.lower, rows.upper)
        if qp.left:
            continue
        least = cost(quadratic, expected)
        assert cost(quadratic, d) == pytest.approx(least, rel=1e-7, abs=1e-8)
        compared += 1
    assert compared > 20


def test_what_the_kernel_leaves_is_condensed_and_counted(monkeypatch):
    structured, condensed = optimiser(), optimiser(qp="condensed")
    rng = np.random.default_rng(7)
    start = random_start(rng)
    objectives = random_objectives(rng, start, structured)
    assert [level.condensed for level in structured.solve(start, objectives).levels] == [0, 0]
    for nothing in (None, lambda *_: 0):
        monkeypatch.setattr(structured_qp, "load_kernel", lambda nothing=nothing: nothing)
        left = structured.solve(start, objectives)
        plain = condensed.solve(start, objectives)
        np.testing.assert_allclose(left.u, plain.u, atol=1e-9)
        assert all(level.condensed > 0 for level in left.levels)
        assert all(level.condensed == 0 for level in plain.levels)


@pytest.mark.parametrize("which", ROBOTS)
def test_levels_reach_what_they_reach_condensed(which):
    """State by state: both ways from the same start."""
    ours, other = optimiser(which), optimiser(which, qp="condensed")
    left = 0
    for seed in range(25):
        rng = np.random.default_rng(seed)
        start = random_start(rng, which)
        objectives = random_objectives(rng, start, ours)
        first, second = ours.solve(start, objectives), other.solve(start, objectives)
        for a, b in zip(first.levels, second.levels, strict=True):
            assert a.succeeded or a.outcome is Outcome.BLOCKED
            left += a.condensed
            assert a.cost <= 1.01 * b.cost + 1e-6
    assert left <= 4
