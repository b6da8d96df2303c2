"""Plans, replayed: the same bits from states, sequences and changes as a bag tells them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from lexstack.mpc import HT_ARCH, Change, SequenceRunner, SequenceTask, plans_of
from lexstack.types import RobotState
from lexstack_bag.errors import BagError
from lexstack_bag.replay.changes import Changes, Question
from lexstack_bag.replay.planner import heard_plans, replay_planner
from lexstack_bag.run.run import (
    PlanStream,
    PlanTopics,
    PlantStream,
    ProgressStream,
    Run,
    SequenceEvent,
    TransitionStream,
)
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import load_htmpc
from support.scenario import CONFIG, changed

DT, EVERY, TICKS = 0.01, 5, 300
GIVE = SequenceTask("give", "ee_position", ((2.7, 0.2, 1.0),), speed=0.5, held=True)
DRIVE = SequenceTask("drive", "base_pose", ((2.6, -0.3, 0.5),), speed=0.5, tolerance=0.05)
MORE = SequenceTask("more", "base_position", ((2.3, 0.1),))
CHANGES = {
    30: Change("insert", "more", task=MORE, before="drive"),
    60: Change("retarget", "drive", ((2.7, -0.2, 0.3),)),
    90: Change("cancel", "more"),
    200: Change("release", "give"),
}


@cache
def resolved():
    config = load_htmpc(CONFIG / "htmpc/lexstack.yaml")
    return replace(changed(), htmpc={"lexstack": config})


@cache
def recorded():
    """Return a run with one robot's sequence, closed over an ideal plant."""
    team = build_team(resolved())
    scenario = resolved().scenario
    blend = scenario.transition.duration
    runner = SequenceRunner(team, 1, resolved().htmpc["lexstack"], blend)
    q = home_of(team, resolved())
    state = RobotState(0, 0.0, q, np.zeros(team.n), q, np.zeros(team.n))
    states, plans, events = [], [], []

    def note(event, changed=""):
        tasks = () if runner.sequence is None else runner.sequence.tasks
        events.append(SequenceEvent(10 * state.tick - 1, state.tick, "ht", event, changed, tasks))

    for tick in range(TICKS):
        states.append(state)
        if tick == 10:
            runner.begin((GIVE, DRIVE), HT_ARCH, state)
            note("begin")
        if tick in CHANGES:
            runner.change(CHANGES[tick], state)
            note(CHANGES[tick].kind, CHANGES[tick].name)
        if tick == 250:
            runner.begin((DRIVE,), HT_ARCH, state)
            note("replace")
        if tick >= 10 and tick % EVERY == 0:
            plans.append(runner.step(state).plan)
        v = state.command.copy()
        if plans:
            v[team.slices[1]] = plans[-1].sample(state.stamp + DT)[1]
        state = RobotState(tick + 1, state.stamp + DT, state.q + DT * v, v, state.q + DT * v, v)
    stream = PlanStream(
        np.array([round(plan.stamp / DT) for plan in plans]),
        np.array([plan.stamp for plan in plans]),
        np.array([0.1 * np.arange(11) for _ in plans]),
        np.array([plan.v.ravel() for plan in plans]),
        np.array([round(10 * plan.stamp / DT) for plan in plans]),
    )
    return Run(
        CONFIG,
        {},
        resolved(),
        plant_of(states),
        {},
        empty(TransitionStream),
        (),
        {},
        0,
        True,
        plan_topics={"robot_b": PlanTopics(stream, empty(ProgressStream), tuple(events))},
    )


@cache
def two_recorded():
    """Return a run in which two robots cross, each with a plan of its own."""
    away = {"robot_a": (0.0, 0.0, 0.0), "robot_b": (2.2, -1.8, 3.14)}
    places = resolved().scenario.robots
    own = replace(
        resolved(),
        scenario=replace(
            resolved().scenario,
            robots={name: replace(place, base=away[name]) for name, place in places.items()},
        ),
    )
    team = build_team(own)
    runners = {i: SequenceRunner(team, i, own.htmpc["lexstack"]) for i in range(2)}
    for runner in runners.values():
        runner._blend = own.scenario.transition.duration
    q = home_of(team, own)
    state = RobotState(0, 0.0, q, np.zeros(team.n), q, np.zeros(team.n))
    goals = ((5.0, 0.0), (2.2, 3.2))
    tasks = [SequenceTask("drive", "base_position", (goal,), speed=0.95) for goal in goals]
    states, plans, events = [], {0: [], 1: []}, {0: [], 1: []}

    def note(robot, event):
        mine = () if event == "end" else (tasks[robot],)
        events[robot].append(SequenceEvent(100 * tick + 10, tick, "ht", event, "", mine))

    for tick in range(350):
        states.append(state)
        for i, runner in runners.items():
            if tick == 10 * i:
                runner.begin((tasks[i],), HT_ARCH, state)
                note(i, "begin")
            if i == 0 and tick == 300:
                runner.end()
                note(0, "end")
            if runner.sequence is not None and tick % EVERY == 0:
                plan = runner.step(state, plans_of(runners)).plan
                plans[i].append((100 * tick + 20 + i, plan))
        v = state.command.copy()
        for i, part in enumerate(team.slices):
            if plans[i]:
                v[part] = plans[i][-1][1].sample(state.stamp + DT)[1]
        q = state.q + DT * v
        state = RobotState(tick + 1, state.stamp + DT, q, v, q, v)
    topics = {
        name: PlanTopics(
            PlanStream(
                np.array([round(plan.stamp / DT) for _, plan in plans[i]]),
                np.array([plan.stamp for _, plan in plans[i]]),
                np.array([0.1 * np.arange(11) for _ in plans[i]]),
                np.array([plan.v.ravel() for _, plan in plans[i]]),
                np.array([sent for sent, _ in plans[i]]),
            ),
            empty(ProgressStream),
            tuple(events[i]),
        )
        for i, name in enumerate(team.names)
    }
    return replace(recorded(), resolved=own, plant=plant_of(states), plan_topics=topics)


def empty(kind):
    return kind(*(np.zeros(0) for _ in kind.__dataclass_fields__))


def plant_of(states):
    columns = [
        np.array([getattr(state, name) for state in states])
        for name in ("tick", "stamp", "q", "v", "q_star", "command")
    ]
    return PlantStream(*columns, *(np.zeros(len(states), np.int64) for _ in range(3)))


def replayed(run, *settings):
    changes = Changes(settings)
    return replay_planner(Question(run, changes, changes.applied(run.resolved)))


def test_all_changes_of_a_sequence_are_replayed_bit_by_bit():
    found = replayed(recorded())
    assert found.identical, found.line()
    assert found.line() == f"htmpc: identical over all {(TICKS - 10) // EVERY} ticks"
    assert found.joints[-1].name == "robot_b/panda_joint7, state 10"


def test_plans_that_avoid_each_other_are_replayed_bit_by_bit():
    found = replayed(two_recorded())
    assert found.identical, found.line()


def test_the_other_robot_s_plan_counts():
    run = two_recorded()
    alone = replace(run, plan_topics={"robot_a": run.plan_topics["robot_a"]})
    assert not replayed(alone).identical
    assert not replayed(run, "htmpc.lexstack.predict_others=false").identical


def test_one_flipped_bit_is_found_at_its_tick():
    run = recorded()
    plan_topics = run.plan_topics["robot_b"]
    velocity = plan_topics.plans.velocity.copy()
    velocity[7, 33] = np.nextafter(velocity[7, 33], np.inf)
    plans = replace(plan_topics.plans, velocity=velocity)
    tampered = replace(run, plan_topics={"robot_b": replace(plan_topics, plans=plans)})
    assert replayed(tampered).first == 10 + 7 * EVERY


def without(event):
    """Return the run without the events of a kind, and the tick of that event."""
    run = recorded()
    plan_topics = run.plan_topics["robot_b"]
    events = tuple(entry for entry in plan_topics.events if entry.event != event)
    tick = next(entry.tick for entry in plan_topics.events if entry.event == event)
    return replace(run, plan_topics={"robot_b": replace(plan_topics, events=events)}), tick


@pytest.mark.parametrize("missing", ["retarget", "cancel", "release", "replace"])
def test_every_event_counts(missing):
    run, tick = without(missing)
    first = replayed(run).first
    assert first is not None
    assert first >= tick


def test_a_change_of_what_the_bag_does_not_hold_is_told():
    with pytest.raises(BagError, match="htmpc: cancel at tick 90: sequence: unknown"):
        replayed(without("insert")[0])


def test_another_parameter_gives_other_plans():
    found = replayed(recorded(), "htmpc.lexstack.ee.tolerance=0.02")
    assert not found.identical


def test_robot_a_hears_the_plans_as_they_were_sent():
    run = recorded()
    plans = run.plan_topics["robot_b"].plans
    heard = list(heard_plans(run, run.team()).until(2**62))
    assert [plan.tick for plan in heard] == plans.tick.tolist()
    assert {plan.robot for plan in heard} == {1}
    assert np.array_equal(heard[3].velocities.ravel(), plans.velocity[3])
    assert heard[3].times.tolist() == plans.times[3].tolist()
