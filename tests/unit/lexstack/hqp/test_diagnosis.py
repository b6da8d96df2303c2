"""What stands in a level's way: known answers, and what happens when the obstacle is taken away."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from lexstack.hqp import DaqpCascade, HqpProblem, describe, explain_unmet_levels
from lexstack.hqp.diagnosis import _forces
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from support.problems import problem

SOLVER = DaqpCascade()
INF = np.inf


def row(name, *coefficients, lower=-INF, upper=INF):
    matrix = np.array([coefficients], dtype=float)
    return LinearTask(name, matrix, np.array([lower]), np.array([upper]))


def to(name, value, *coefficients):
    return row(name, *coefficients, lower=value, upper=value)


def asked(*levels, bound=1.0):
    limit = np.full(levels[0][0].matrix.shape[1], bound)
    given = HqpProblem(tuple(levels), Bounds(-limit, limit))
    return given, explain_unmet_levels(given, SOLVER.solve(given))


def test_nothing_is_said_where_every_level_is_met():
    _, found = asked((to("a", 0.5, 1, 1),), (to("b", 0.2, 1, -1),))
    assert found == ()
    assert describe(found, ("x", "y")) == ""


def test_a_bound_in_the_way_is_named_with_its_side():
    _, (level,) = asked((to("reach", 5.0, 1, 0),), (to("rest", 0.0, 0, 1),))
    assert (level.level, level.task, level.row) == (0, "reach", 0)
    assert level.residual == pytest.approx(-4.0)
    (obstacle,) = level.obstacles
    assert (obstacle.joint, obstacle.side) == (0, 1)
    assert obstacle.force == pytest.approx(1.0)
    said = describe((level,), ("robot_a/x", "robot_a/y"))
    assert said == "level 1: reach row 1 misses by -4, held by upper bound of robot_a/x (1)"


def test_a_lower_bound_and_the_ranking():
    _, (level,) = asked((to("reach", -9.0, 3, 1),))
    assert [(o.joint, o.side) for o in level.obstacles] == [(0, -1), (1, -1)]
    assert [o.force for o in level.obstacles] == pytest.approx([3.0, 1.0])


def test_a_row_of_a_higher_level_in_the_way():
    _, (level,) = asked((to("hold", 0.3, 1, 1),), (to("want", 0.9, 1, 1),))
    assert (level.level, level.task) == (1, "want")
    (obstacle,) = level.obstacles
    assert (obstacle.joint, obstacle.level, obstacle.task, obstacle.row) == (-1, 0, "hold", 0)
    assert obstacle.side == 1
    assert "hold row 1 of level 1" in describe((level,), ("x", "y"))


def test_an_inequality_row_in_the_way_with_the_right_side():
    _, (level,) = asked((row("wall", 1, 0, lower=-0.2, upper=0.4),), (to("want", 0.9, 1, 0),))
    (obstacle,) = level.obstacles
    assert (obstacle.task, obstacle.side) == ("wall", 1)


def test_rows_that_contradict_each_other_have_nothing_in_their_way():
    _, (level,) = asked((to("a", 0.0, 1, 0), to("b", 0.4, 1, 0)))
    assert level.obstacles == ()
    assert "cannot all be met" in describe((level,), ("x", "y"))


def test_a_bound_that_is_touched_and_does_not_press_is_not_named():
    given = HqpProblem(
        ((to("edge", 1.0, 1, 0, 0),), (to("far", 3.0, 0, 1, 0),)),
        Bounds(-np.ones(3), np.ones(3)),
    )
    (level,) = explain_unmet_levels(given, SOLVER.solve(given))
    assert [o.joint for o in level.obstacles] == [1]


@pytest.mark.parametrize("seed", range(12))
def test_the_slack_falls_by_the_force_when_the_bound_gives_way(seed):
    given = problem("infeasible", seed, 12, 1)
    before = SOLVER.solve(given)
    (level,) = explain_unmet_levels(given, before)
    assert level.obstacles
    for obstacle in level.obstacles[:3]:
        lower, upper = given.bounds.lower.copy(), given.bounds.upper.copy()
        (upper if obstacle.side > 0 else lower)[obstacle.joint] += 1e-4 * obstacle.side
        after = SOLVER.solve(replace(given, bounds=Bounds(lower, upper)))
        fallen = (before.slacks[0] - after.slacks[0]) / 1e-4
        assert fallen == pytest.approx(obstacle.force, rel=0.02, abs=1e-3)


@pytest.mark.parametrize("seed", range(12))
def test_without_the_strongest_bound_the_level_is_better_and_without_an_unnamed_one_it_is_not(seed):
    given = problem("infeasible", seed, 12, 1)
    before = SOLVER.solve(given)
    (level,) = explain_unmet_levels(given, before)

    def slack_without(joint):
        lower, upper = given.bounds.lower.copy(), given.bounds.upper.copy()
        lower[joint], upper[joint] = -INF, INF
        return SOLVER.solve(replace(given, bounds=Bounds(lower, upper))).slacks[0]

    named = {obstacle.joint for obstacle in level.obstacles}
    assert slack_without(level.obstacles[0].joint) < before.slacks[0] - 1e-6
    for joint in set(range(12)) - named:
        assert slack_without(joint) == pytest.approx(before.slacks[0], abs=1e-8)


def test_forces_of_one_sign_or_any_are_found_without_a_warning():
    """Limits without an end, columns that stand twice or are zero: and the forces are optimal."""
    rng = np.random.default_rng(0)
    for _ in range(300):
        rows, count = int(rng.integers(2, 12)), int(rng.integers(2, 16))
        columns = rng.normal(size=(rows, count)) * (rng.random((rows, count)) < 0.6)
        columns[:, 1] = columns[:, 0]
        target = rng.normal(size=rows)
        least = np.where(rng.random(count) < 0.5, 0.0, -INF)
        most = np.where((least < 0.0) & (rng.random(count) < 0.5), 0.0, INF)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            forces = _forces(columns, target, (least, most))
        assert (forces >= least - 1e-9).all()
        assert (forces <= most + 1e-9).all()
        pull = columns.T @ (target - columns @ forces)  # what a force would gain by growing
        assert (pull[(most > 0.0) & (forces >= -1e-9)] < 1e-7).all()
        assert (pull[(least < 0.0) & (forces <= 1e-9)] > -1e-7).all()


def test_a_line_about_many_levels_and_obstacles_stays_short():
    n = 30
    levels = [(to(f"want{k}", 90.0, *np.roll(np.ones(n), k)),) for k in range(12)]
    _, found = asked(*levels)
    said = describe(found, [f"robot_a/joint{k}" for k in range(n)])
    assert len(found) > 8
    assert f"… and {len(found) - 4} more" in said
    assert f"… and {n - 4} more" in said
    assert len(said) < 1200
