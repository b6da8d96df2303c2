"""Damping near singularities: what it is made from, and that nothing else changes."""

import dataclasses

import numpy as np
import pytest

from lexstack.hqp import Damper, HqpProblem, damping, explain_unmet_levels, make_solver, regular
from lexstack.hqp.groups import groups_of
from lexstack.hqp.lift import Above, Bending
from lexstack.hqp.valley import logarithm
from lexstack.limits import Bounds, target_bounds
from lexstack.references import Motion, References
from lexstack.robots import Pose, from_rpy
from lexstack.tasks import LevelConfig, StackConfig, TaskConfig, build_stack
from support.scenario import home, random_q, state_at, team

BOTH = {"relative_pose": {"other": "robot_b"}}
STRETCHED = [0.0, -0.2554, 0.0, -0.4670, 0.0, 3.0348, 0.0]  # the tool is as high as can be


def stack_of(*kinds, robot=None, weight=1.0):
    levels = tuple(
        LevelConfig(
            (
                TaskConfig(
                    kind,
                    robot="robot_a" if kind in BOTH else robot,
                    weight=weight,
                    parameters=BOTH.get(kind, {}),
                ),
            )
        )
        for kind in kinds
    )
    return build_stack(StackConfig("s", "", levels), team())


def stretched():
    """Return both robots with their arms straight up."""
    q = home()
    for part in team().slices:
        q[part][3:] = STRETCHED
    return q


def references(q, aim=(0.0, 0.0, 1.0), base=0.0):
    tools = team().tools(q)
    poses = tuple(Pose(tool.position + np.array(aim), tool.rotation) for tool in tools)
    return References(poses, tuple(q[part][:3] + base for part in team().slices))


def problem_at(stack, q, aim=(0.0, 0.0, 1.0), base=0.0):
    kinematics = team().kinematics(state_at(q))
    levels = stack.linearise(kinematics, references(q, aim, base))
    return HqpProblem(levels, target_bounds(q, team().limits, team().dt)), kinematics


def damped_at(stack, q, **options):
    given, kinematics = problem_at(stack, q, **options)
    return given, Damper(team(), team().dt).damped(given, kinematics, team().limits)


@pytest.mark.parametrize("kind", ["ee_pose", "ee_position", "relative_pose"])
@pytest.mark.parametrize("weight", [1.0, 4.0])
def test_what_is_known_of_a_level_is_its_second_derivative(kind, weight):
    """J^T D J + B(e) is that of ½ |e|^2, with e before the task shortened it."""
    rng = np.random.default_rng(5)
    stack, q = stack_of(kind, robot="robot_a", weight=weight), random_q(rng)
    goals = references(q, rng.normal(size=3))
    turned = [Pose(pose.position, from_rpy((0.9, -0.7, 0.4)) @ pose.rotation) for pose in goals.ee]
    goals = References((goals.ee[0], turned[1]) if kind == "relative_pose" else tuple(turned),
                       goals.base)  # fmt: skip

    def level_at(there):
        kinematics = team().kinematics(state_at(there))
        bounds = target_bounds(there, team().limits, team().dt)
        given = HqpProblem(stack.linearise(kinematics, goals), bounds)
        (group,) = [group for group in groups_of(given, team().slices) if group.ranks]
        (level,) = group.levels(given)
        return group, level, kinematics

    group, level, kinematics = level_at(q)
    above = Above.of_held(np.zeros(group.size, dtype=bool))
    bending = Bending(level, above, kinematics, group.places)
    error = level.unsaturated()
    found = level.matrix.T @ level.matrix
    found = found + bending.at(error) + logarithm(level, error, level.matrix)
    step, columns = 1e-6, []
    for i in np.arange(team().n)[group.columns]:
        gradients = []
        for sign in (step, -step):
            there = q.copy()
            there[i] += sign
            _, moved, _ = level_at(there)
            gradients.append(moved.matrix.T @ moved.unsaturated())
        columns.append((gradients[1] - gradients[0]) / (2.0 * step))
    np.testing.assert_allclose(found, np.array(columns), atol=1e-6 * weight)


def test_where_all_levels_are_regular_the_problem_is_the_very_same_one():
    for kinds in (("ee_pose", "base"), ("ee_pose", "posture"), ("base", "ee_pose")):
        given, damped = damped_at(stack_of(*kinds), home(), aim=(0.1, 0.0, 0.1), base=0.1)
        assert damped.problem is given, kinds
        assert damped.near == ()


def test_a_stretched_arm_whose_target_is_beyond_gets_rows_and_says_so():
    given, damped = damped_at(stack_of("ee_position", robot="robot_a"), stretched())
    assert damped.problem is not given
    (near,) = damped.near
    assert (near.level, near.tasks) == (0, "robot_a/ee_position")
    assert near.sigma < 0.15
    assert near.rows > 0
    assert damped.problem.levels[0][0].matrix is given.levels[0][0].matrix


def test_rows_of_one_robot_are_zero_for_all_others():
    _, damped = damped_at(stack_of("ee_pose"), stretched())
    added = [task for task in damped.problem.levels[0] if "damping" in task.name]
    assert len(added) == 2
    for task, other in zip(added, reversed(team().slices), strict=True):
        assert not task.matrix[:, other].any()


def test_slacks_and_rows_are_those_of_the_problem_as_it_was_given():
    stack = stack_of("collision_avoidance", "ee_position", "velocity_damping")
    given, damped = damped_at(stack, stretched())
    assert damped.problem is not given
    solver = make_solver()
    first = damped.own(solver.solve(damped.problem, damped.warm(None)))
    again = damped.own(solver.solve(damped.problem, damped.warm(first)))
    np.testing.assert_allclose(again.chi, first.chi, atol=1e-9)
    rows = sum(task.lower.size for level in given.levels for task in level)
    assert first.rows.size == rows
    assert solver.solve(given, first).solved
    for k, level in enumerate(given.levels):
        residual = np.concatenate([task.residual(first.chi) for task in level])
        assert first.slacks[k] == pytest.approx(np.linalg.norm(residual))
    names = {task.name for level in given.levels for task in level}
    assert all(entry.task in names for entry in explain_unmet_levels(given, first))


def test_an_inequality_row_keeps_holding_where_a_level_below_is_damped():
    stack = stack_of("collision_avoidance", "ee_position", "velocity_damping")
    given, damped = damped_at(stack, stretched())
    solution = make_solver().solve(damped.problem)
    for task in given.levels[0]:
        assert np.abs(task.residual(solution.chi)).max(initial=0.0) <= 1e-9


def test_what_is_no_number_leaves_the_problem_as_it_is_and_is_said():
    given, kinematics = problem_at(stack_of("ee_pose"), stretched())
    task = given.levels[0][0]
    spoilt = dataclasses.replace(task, matrix=np.full_like(task.matrix, np.nan))
    given = HqpProblem(((spoilt, given.levels[0][1]),), given.bounds)
    damped = Damper(team(), team().dt).damped(given, kinematics, team().limits)
    assert damped.problem is given
    assert "no damping" in damped.failure


def test_a_factorisation_that_fails_leaves_the_problem_as_it_is_and_is_said(monkeypatch):
    def fail(*_args):
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr(damping, "lift", fail)
    given, damped = damped_at(stack_of("ee_pose"), stretched())
    assert damped.problem is given
    solution = damped.own(make_solver().solve(given))
    assert solution.solved
    assert "SVD did not converge" in solution.undamped


def test_no_task_and_an_empty_team_of_levels_are_regular():
    n = team().n
    given = HqpProblem((), Bounds(-np.ones(n), np.ones(n)))
    kinematics = team().kinematics(state_at(home()))
    assert Damper(team(), team().dt).damped(given, kinematics, team().limits).problem is given


def test_a_level_close_to_a_singularity_is_told_even_where_it_needs_no_damping():
    q = stretched()
    for part in team().slices:
        q[part][4] += 0.5 * np.pi  # forward: the base cannot go back with the tool where it is
    stack = stack_of("ee_position", "base", robot="robot_a")
    given, damped = damped_at(stack, q, aim=(0.0, 0.0, 0.0), base=np.array([1.0, 0.0, 0.0]))
    assert damped.problem is given
    assert [(near.level, near.rows) for near in damped.near] == [(1, 0)]
    solution = damped.own(make_solver().solve(damped.problem))
    assert str(solution.near[0]).startswith("level 2: robot_a/base (sigma ")


def test_a_level_below_is_damped_by_what_the_level_above_bends():
    """The base cannot go back with the tool of a stretched arm where it is."""
    q = stretched()
    for part in team().slices:
        q[part][4] += 0.5 * np.pi
    stack = stack_of("ee_position", "base", robot="robot_a")
    _, damped = damped_at(stack, q, aim=(0.0, 0.0, 0.0), base=np.array([-1.0, 0.0, 0.0]))
    assert [(near.level, near.rows > 0) for near in damped.near] == [(1, True)]


@pytest.mark.parametrize("seed", range(4))
def test_a_level_that_the_quick_look_spares_gets_no_row_from_the_full_one(seed, monkeypatch):
    """Both are about the same inequality; the quick look leaves what is near it to the full one."""
    rng = np.random.default_rng([7, seed])
    stack, spared = stack_of("ee_pose", "base"), 0
    for _ in range(60):
        q = random_q(rng)
        options = {"aim": 0.3 * rng.normal(size=3), "base": rng.normal()}
        _, quick = damped_at(stack, q, **options)
        with monkeypatch.context() as patch:
            patch.setattr(regular, "_bends_little", lambda *_args: False)
            _, full = damped_at(stack, q, **options)
        if quick.problem is quick.given and not quick.near:
            assert full.problem is full.given
            assert not full.near
            spared += 1
        else:
            assert [entry.rows for entry in quick.near] == [entry.rows for entry in full.near]
    assert spared > 5


def test_a_short_row_of_a_jacobian_is_a_lost_direction_and_not_another_unit():
    """Brought to norm 1 by itself, the rounding of a stretched arm asked for any velocity."""
    given, _ = problem_at(stack_of("ee_position"), stretched())
    (first, *_), *below = given.levels
    assert first.curve is not None
    short = np.zeros_like(first.matrix)
    short[2, 3] = 1e-12
    matrix = np.where(np.arange(3)[:, None] == 2, short, first.matrix)
    rows = dataclasses.replace(first, matrix=matrix)
    box = Bounds(np.full(team().n, -5.0), np.full(team().n, 5.0))
    solution = make_solver().solve(HqpProblem(((rows,), *below), box))
    assert abs(solution.chi[3]) < 1.0, "nobody asks this joint to move at its bound"


@pytest.mark.parametrize("kind", ["ee_pose", "frame_pose"])
def test_the_velocity_of_a_reference_is_not_taken_for_an_error(kind):
    """It is added to what the rows ask for, and changes neither the rows nor what they remove."""
    stack, q = stack_of(kind, "posture", robot="robot_a"), stretched()
    still, twist = references(q), np.array([0.2, 0.1, 0.3, 0.1, -0.2, 0.3])
    motion = Motion(twists={(0, "tool"): twist})
    moving = References(still.ee, still.base, 1, motion)
    kinematics = team().kinematics(state_at(q))
    bounds = target_bounds(q, team().limits, team().dt)
    found = []
    for there in (still, moving):
        given = HqpProblem(stack.linearise(kinematics, there), bounds)
        damped = Damper(team(), team().dt).damped(given, kinematics, team().limits)
        assert damped.near[0].rows
        found.append((given, damped.problem))
    (given, one), (fed, other) = found
    assert np.abs(fed.levels[0][0].feed).max() > 0.1
    for level, another in zip(one.levels, other.levels, strict=True):
        for task, same in zip(level, another, strict=True):
            # Rows of damping have no order and no signs: what counts is their sum of squares.
            rows, others = task.matrix, same.matrix
            np.testing.assert_allclose(others.T @ others, rows.T @ rows, atol=1e-6)
            asked, again = rows.T @ task.lower, others.T @ same.correction
            np.testing.assert_allclose(again, asked, atol=1e-6)
    change = other.levels[0][0].lower - one.levels[0][0].lower
    np.testing.assert_allclose(change, fed.levels[0][0].feed, atol=1e-9)


def test_a_level_at_its_reference_has_no_error_however_fast_the_reference_moves():
    stack, q = stack_of("ee_pose", "posture", robot="robot_a"), home()
    motion = Motion(twists={(0, "tool"): np.array([0.5, 0.5, 0.5, 1.0, 1.0, 1.0])})
    moving = References(team().tools(q), tuple(q[part][:3] for part in team().slices), 1, motion)
    levels = stack.linearise(team().kinematics(state_at(q)), moving)
    given = HqpProblem(levels, target_bounds(q, team().limits, team().dt))
    (group,) = groups_of(given, team().slices)
    np.testing.assert_allclose(group.levels(given)[0].error, 0.0, atol=1e-12)
