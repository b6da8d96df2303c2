"""The other robot is avoided where it will be: along its plan, or braking; not where it stands."""

import dataclasses

import numpy as np
import pytest

from lexstack.mpc import (
    DEFAULT_HTMPC,
    HT_ARCH,
    CollisionScene,
    Htmpc,
    Objective,
    OtherRobot,
    SequenceRunner,
    SequenceTask,
    Start,
    plans_of,
)
from lexstack.mpc.other_robots import braking, scene_of
from lexstack.robots import RobotModel, Team
from lexstack.types import RobotState
from support.htmpc import config, random_start, robot

DT = 0.01
TIMES = np.arange(1, 11) * 0.1


def test_a_robot_that_brakes_stops_where_v_squared_over_2a_says():
    model, rng = robot(), np.random.default_rng(0)
    start = random_start(rng)
    there = braking(model, start.q, start.v, np.array([0.05, 0.5, 100.0]))
    limit = model.limits.acceleration
    stop = start.q + np.sign(start.v) * start.v**2 / (2.0 * limit)
    np.testing.assert_allclose(there[-1], stop, rtol=1e-12, atol=1e-12)
    # 50 000 steps of a simulation that knows nothing of the formula.
    q, v = start.q.copy(), start.v.copy()
    for _ in range(50000):
        q += 1e-5 * v
        v = np.sign(v) * np.maximum(np.abs(v) - 1e-5 * limit, 0.0)
    np.testing.assert_allclose(there[1], q, atol=5e-5)


def test_a_robot_at_rest_stays_to_the_bit():
    model = robot()
    q = model.home((1.0, 2.0, 0.3))
    there = OtherRobot(model, q, np.zeros(model.n)).configurations(3.0, 3.0 + TIMES)
    np.testing.assert_array_equal(there, np.tile(q, (10, 1)))


def test_a_plan_counts_until_it_ends():
    model = robot()
    solver = Htmpc(model, config(), ())
    start = Start(2.0, model.home((0.0, 0.0, 0.0)), np.full(model.n, 0.1))
    goal = np.tile([1.0, 0.0], (10, 1))
    plan = solver.solve(start, (Objective("drive", "base_position", goal),))
    other = OtherRobot(model, start.q, start.v, plan)
    np.testing.assert_allclose(other.configurations(2.0, 2.0 + TIMES), plan.q[1:], atol=1e-12)
    late = other.configurations(2.5, 2.5 + TIMES)
    np.testing.assert_allclose(late[:5], plan.q[6:], atol=1e-12)
    np.testing.assert_allclose(late[5:], np.tile(plan.q[-1], (5, 1)), atol=1e-12)
    over = other.configurations(plan.end, plan.end + TIMES)
    np.testing.assert_array_equal(
        over, braking(model, start.q, start.v, plan.end + TIMES - plan.end)
    )


def test_others_are_the_same_as_their_spheres():
    """``others`` of a solve is the scene of their spheres, beside what is around."""
    model = robot()
    solver = Htmpc(model, config())
    start = Start(0.0, model.home((0.0, 0.0, 0.0)), np.zeros(model.n))
    drive = (Objective("drive", "base_position", np.tile([2.0, 0.0], (10, 1))),)
    other = OtherRobot(model, model.home((1.5, 1.2, 0.0)), np.array([0, -0.8, *np.zeros(7)]))
    post = CollisionScene(np.full((10, 1, 3), 0.9), np.array([0.1]))
    scene = scene_of([other], 0.0, TIMES)
    assert scene.centers.shape == (10, len(model.config.spheres), 3)
    both = solver.solve(start, drive, around=post, others=[other])
    joined = solver.solve(start, drive, around=post.joined(scene))
    np.testing.assert_array_equal(both.u, joined.u)
    alone = solver.solve(start, drive, around=post)
    assert np.abs(alone.u - both.u).max() > 1e-3


def test_a_robot_without_spheres_is_in_nobody_s_way():
    model = RobotModel("bare", dataclasses.replace(robot().config, spheres=()))
    assert scene_of([OtherRobot(model, model.home(), np.zeros(model.n))], 0.0, TIMES) is None


def crossing(predict, bases, goals, every):
    """Return the least distance of two robots that cross each other's way, and when both are there.

    Each has a sequence of its own at 0.95 m/s and is an obstacle for the other one.
    """
    models = tuple(RobotModel(name, robot().config) for name in "ab")
    team = Team(models, DT)
    own = dataclasses.replace(DEFAULT_HTMPC, predict_others=predict)
    runners = {i: SequenceRunner(team, i, own) for i in range(2)}
    state = RobotState.at_rest(team.home(dict(zip("ab", bases, strict=True))))
    for i, goal in enumerate(goals):
        drive = SequenceTask("drive", "base_position", (goal,), speed=0.95, tolerance=0.03)
        runners[i].begin((drive,), HT_ARCH, state)
    least, there = np.inf, {}
    while len(there) < 2 and state.stamp < 12.0:
        if state.tick % every == 0:
            plans = []
            for i, runner in runners.items():
                progress = runner.step(state, plans_of(runners))
                plans.append(progress.plan)
                if progress.sequence.done:
                    there.setdefault(i, state.stamp)
        v = np.concatenate([plan.sample(state.stamp + DT)[1] for plan in plans])
        q, tick = state.q + DT * v, state.tick + 1
        state = RobotState(tick, tick * DT, q, v, q, v)
        spheres = team.spheres(q)
        first = spheres.owners == 0
        apart = spheres.centers[first][:, None] - spheres.centers[~first]
        reach = spheres.radii[first][:, None] + spheres.radii[~first]
        least = min(least, (np.linalg.norm(apart, axis=2) - reach).min())
    return least, max(there.values()) if len(there) == 2 else np.inf


@pytest.mark.parametrize(
    ("every", "bases", "goals"),
    [
        (5, ((0, 0, 0), (2.2, -1.8, 3.14)), ((5.0, 0.0), (2.2, 3.2))),
        (20, ((0, 0, 0), (2.0, -2.5, 1.57)), ((5.0, 0.0), (2.0, 2.5))),
        (20, ((0, 0, 0), (0.8, -1.9, 0)), ((5.0, 0.0), (4.2, 1.5))),
    ],
)
def test_robots_that_know_each_other_s_plans_pass_where_frozen_ones_collide(every, bases, goals):
    frozen, late = crossing(False, bases, goals, every)
    planned, soon = crossing(True, bases, goals, every)
    assert frozen < 0.0, "the spheres of one are inside those of the other"
    assert planned > 0.03, "the margin is 50 mm, kept by a barrier"
    assert soon < late - 0.3, "and sooner"


def test_a_robot_on_its_stack_is_avoided_where_it_can_stop():
    """It comes at 0.9 m/s and brakes too late for one that takes it to stand where it is."""
    team = Team(tuple(RobotModel(name, robot().config) for name in "ab"), DT)
    gap = {}
    for predict in (False, True):
        own = dataclasses.replace(DEFAULT_HTMPC, predict_others=predict)
        runner = SequenceRunner(team, 0, own)
        q = team.home({"a": (0.0, 0.0, 0.0), "b": (0.0, 1.1, 0.0)})
        v = np.zeros(team.n)
        v[team.slices[1].start + 1] = -0.9
        state = RobotState(0, 0.0, q, v, q, v)
        stay = SequenceTask("stay", "base_position", ((0.0, 0.0),))
        runner.begin((stay,), HT_ARCH, state)
        gap[predict] = -runner.step(state).plan.q[-1, 1]
    assert gap[True] > gap[False] + 0.05, "it makes way at once"
