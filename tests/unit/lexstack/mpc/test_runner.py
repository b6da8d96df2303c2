"""A sequence on one robot, closed over an ideal plant: it gets done, changes, and refuses."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import (
    ARCHITECTURES,
    Change,
    SequenceConfig,
    SequenceRunner,
    SequenceTask,
    SequenceTaskConfig,
    tasks_of,
)
from lexstack.robots import RobotModel, Team
from lexstack.types import RobotState
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import load_htmpc, load_robot
from support.scenario import CONFIG, changed, resolved

DT, EVERY = 0.01, 5
GIVE = SequenceTask("give", "ee_position", ((1.1, 0.2, 1.1),), dwell=0.1)
DRIVE = SequenceTask("drive", "base_position", ((0.8, -0.3),), speed=0.5, tolerance=0.05)


@cache
def far_team():
    robots = resolved().scenario.robots
    away = {
        n: dataclasses.replace(p, base=(0.0, 4.0 * i, 0.0))
        for i, (n, p) in enumerate(robots.items())
    }
    return build_team(changed(robots=away)), changed(robots=away)


def least_height(ground):
    """Return how near a lone robot's arm comes to the floor, its tool sent below it [m]."""
    model = RobotModel("alone", load_robot(CONFIG / "robots/ur10_ridgeback.yaml"))
    team = Team((model,), DT)
    config = load_htmpc(CONFIG / "htmpc/lexstack.yaml")
    collision = dataclasses.replace(config.collision, ground=ground)
    runner = SequenceRunner(team, 0, dataclasses.replace(config, collision=collision))
    q = model.home((0.0, 0.0, 0.0))
    state = RobotState(0, 0.0, q, np.zeros(team.n), q, np.zeros(team.n))
    below = SequenceTask("below", "ee_position", ((1.2, 0.2, -0.3),))
    runner.begin((below,), ARCHITECTURES["ht"], state)
    on_arm = np.array([sphere.link != "base" for sphere in model.config.spheres])
    heights = []
    for _ in range(round(4.0 / DT)):
        spheres = team.spheres(state.q)
        heights.append((spheres.centers[on_arm, 2] - spheres.radii[on_arm]).min())
        if state.tick % EVERY == 0:
            plan = runner.step(state).plan
        v = plan.sample(state.stamp + DT)[1]
        q = state.q + DT * v
        state = RobotState(state.tick + 1, state.stamp + DT, q, v, q, v)
    return min(heights)


def test_a_lone_robot_without_obstacles_keeps_off_the_floor():
    assert least_height(ground=False) < -0.05, "the target is below the floor"
    assert least_height(ground=True) > 0.0


@cache
def optimised():
    return SequenceRunner(far_team()[0], 0, load_htmpc(CONFIG / "htmpc/lexstack.yaml"))


@pytest.fixture
def runner():
    made = optimised()
    yield made
    made.end()


def start(runner, tasks=(GIVE, DRIVE), architecture="ht"):
    team, scenario = far_team()
    q = home_of(team, scenario)
    state = RobotState(0, 0.0, q, np.zeros(team.n), q, np.zeros(team.n))
    runner.begin(tasks, ARCHITECTURES[architecture], state)
    return state


def go_on(runner, state, seconds, event=None):
    """Integrate the plan from a state; returns the last state and all progress."""
    progress, found = None, []
    for _ in range(round(seconds / DT)):
        if state.tick % EVERY == 0:
            if event is not None:
                event(state)
            progress = runner.step(state)
            found.append(progress)
            if progress.sequence.done:
                break
        v = state.command.copy()
        v[:10] = progress.plan.sample(state.stamp + DT)[1]
        q = state.q + DT * v
        state = RobotState(state.tick + 1, state.stamp + DT, q, v, q, v)
    return state, found


@pytest.mark.parametrize(
    ("architecture", "tasks"),
    # With arm and base apart the base must be there before the arm can reach.
    [("ht", (GIVE, DRIVE)), ("st", (dataclasses.replace(DRIVE, points=((0.6, 0.1),)), GIVE))],
)
def test_all_tasks_get_done_in_their_order(runner, architecture, tasks):
    _, found = go_on(runner, start(runner, tasks, architecture), 8.0)
    assert found[-1].sequence.done
    firsts = [progress.sequence.first for progress in found]
    assert firsts == sorted(firsts)
    assert all(progress.plan.solved for progress in found)
    limits = far_team()[0].robots[0].limits
    for progress in found:
        assert (np.abs(progress.plan.u) <= limits.acceleration * (1.0 + 1e-6)).all()
        assert (np.abs(progress.plan.v) <= limits.velocity * (1.0 + 1e-6)).all()


def test_a_held_task_waits_for_its_release(runner):
    held = dataclasses.replace(GIVE, held=True)

    def release(state):
        if state.tick == 300:
            runner.change(Change("release", "give"), state)

    _, found = go_on(runner, start(runner, (held, DRIVE)), 8.0, release)
    last_held = max(p.plan.stamp for p in found if p.sequence.first == 0)
    assert 2.9 <= last_held <= 3.2
    assert found[-1].sequence.done


def test_a_target_that_moves_is_reached_where_it_is_now(runner):
    goal = (1.0, 0.5, 0.9)

    def move(state):
        if state.tick == 50:
            runner.change(Change("retarget", "give", (goal,)), state)

    state, found = go_on(runner, start(runner, (GIVE,)), 8.0, move)
    assert found[-1].sequence.done
    tool = far_team()[0].robots[0].tool(state.q[:10])[0].position
    assert np.linalg.norm(tool - goal) < 0.02


@pytest.mark.parametrize("blend", [0.0, 0.6])
def test_a_gap_that_robot_a_still_carries_is_not_taken_into_the_plans(runner, blend):
    runner._blend = blend  # as given when it is made
    gap = np.zeros(10)
    gap[[0, 5]] = 0.08, 0.3  # m/s, rad/s: what a blend begins with
    state, before, kicks = start(runner), None, []
    for _ in range(100):
        if state.tick % EVERY == 0:
            plan = runner.step(state).plan
            if before is not None:
                kicks.append(np.abs(plan.v[0] - before.sample(state.stamp)[1]).max())
            before = plan
        fades = max(0.0, 1.0 - (state.stamp + DT) / 0.6)
        v = state.command.copy()
        v[:10] = plan.sample(state.stamp + DT)[1] + fades * gap
        q = state.q + DT * v
        state = RobotState(state.tick + 1, state.stamp + DT, q, v, q, v)
    runner._blend = 0.0
    within, after = kicks[:11], kicks[12:]
    assert max(after) < 1e-9, "then plans begin with the command, which is the plan"
    assert (max(within) < 1e-9) == (blend > 0.0)


def test_tasks_are_inserted_and_cancelled(runner):
    state = start(runner)
    more = SequenceTask("more", "base_position", ((0.4, 0.0),), tolerance=0.05)
    runner.change(Change("insert", "more", task=more, before="drive"), state)
    assert [task.name for task in runner.sequence.tasks] == ["give", "more", "drive"]
    runner.change(Change("cancel", "give"), state)
    assert [task.name for task in runner.sequence.tasks] == ["more", "drive"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (Change("release", "x"), "unknown task 'x'; known: give, drive"),
        (Change("retarget", "x", ((0.0, 0.0, 0.0),)), "unknown task 'x'"),
        (Change("insert", "give", task=GIVE), "two tasks have the name 'give'"),
        (Change("insert", "y", task=dataclasses.replace(GIVE, name="y"), before="x"), "unknown"),
        (Change("retarget", "give", ((np.nan, 0.0, 0.0),)), "finite"),
    ],
)
def test_a_wrong_change_is_refused_and_changes_nothing(runner, change, message):
    state = start(runner)
    before = runner.sequence
    with pytest.raises(InputError, match=message):
        runner.change(change, state)
    assert runner.sequence is before


def test_a_change_names_the_task_with_its_new_goal(runner):
    start(runner)
    moved = runner.task_after(Change("retarget", "give", ((1.0, 0.0, 4.0),)))
    assert moved == dataclasses.replace(runner.task("give"), points=((1.0, 0.0, 4.0),))
    more = dataclasses.replace(GIVE, name="more")
    assert runner.task_after(Change("insert", "more", task=more)) == more
    assert runner.task_after(Change("release", "give")) is None
    assert runner.task_after(Change("cancel", "give")) is None
    with pytest.raises(InputError, match="unknown task 'x'"):
        runner.task_after(Change("retarget", "x", ((0.0, 0.0, 0.0),)))


def test_without_a_sequence_there_is_nothing_to_plan_or_change(runner):
    state = start(runner)
    runner.end()
    with pytest.raises(InputError, match="none is under way"):
        runner.step(state)
    with pytest.raises(InputError, match="none is under way"):
        runner.change(Change("release", "give"), state)


def test_rounds_repeat_all_tasks_under_new_names():
    task = SequenceTaskConfig("give", "ee_position", ((1.0, 0.0, 1.0),))
    made = tasks_of(SequenceConfig("robot_a", (task,), rounds=3))
    assert [each.name for each in made] == ["give", "give#2", "give#3"]
    assert {each.points for each in made} == {((1.0, 0.0, 1.0),)}
