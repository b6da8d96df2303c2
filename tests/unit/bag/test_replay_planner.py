"""Plans, replayed: the same bits from states, sequences and changes as a bag tells them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from lexstack.mpc import HT_ARCH, Change, SequenceRunner, SequenceTask
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
