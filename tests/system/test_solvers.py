"""Several solvers: each solves its robots' part of the stack, and all are followed."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import Question, replay_controller, replay_solver
from lexstack_bag.run.partial_chi import joined
from lexstack_bag.run.reader import read_run
from lexstack_config.resolved import load_scenario
from lexstack_config.scenario import EventConfig
from lexstack_experiments.loop import Loop
from lexstack_interfaces.msg import TransitionStatus
from lexstack_testing.played_run import together
from support.runs import chi_by_tick, read, transitions
from support.scenario import CONFIG

pytestmark = pytest.mark.system


def scenario():
    """Return four of the eight robots with two solvers, one of which moves all four."""
    whole = load_scenario(CONFIG / "scenarios" / "eight_robots.yaml")
    names = list(whole.scenario.robots)[:4]

    def first(entries):
        return {name: entries[name] for name in names}

    stacks = {name: whole.stacks[name] for name in ("track", "reach_base")}
    stacks["one"] = replace(whole.stacks["posture"], name="one", robots=(names[3],))
    return replace(
        whole,
        stacks=stacks,
        scenario=replace(
            whole.scenario,
            robots=first(whole.scenario.robots),
            base_target=first(whole.scenario.base_target),
            duration=1.6,
            solvers=2,
            events=(
                EventConfig(at=0.2, switch="reach_base", duration=0.5),
                EventConfig(at=1.0, switch="one", duration=0.4),
            ),
        ),
    )


def test_two_solvers_give_the_very_motion_of_one(tmp_path):
    resolved = scenario()
    with together(resolved, tmp_path) as run:
        run.play()
        assert run.end() == []
    bag = tmp_path / "bag"
    parts = read(bag, "/robot_b/chi")["/robot_b/chi"]
    by_solver = {}
    for message in parts:
        by_solver.setdefault(message.sender.partition("@")[0], []).append(message)
    assert set(by_solver) == {"stack_solver", "stack_solver_2"}
    robots = list(resolved.scenario.robots)
    assert {tuple(m.robots) for m in by_solver["stack_solver"]} == {tuple(robots[:2])}
    second = {(m.stack, tuple(m.robots)) for m in by_solver["stack_solver_2"]}
    assert second == {("reach_base", tuple(robots[2:])), ("one", (robots[3],))}
    told = transitions(bag)
    blends = [m for m in told if m.phase == TransitionStatus.BLENDING]
    assert {m.to_stack for m in blends} == {"reach_base", "one"}
    assert {m.source for m in blends} == {"robot_b"}
    assert not any(m.reason for m in told)
    # One solver, in this process.
    alone = Loop(replace(resolved, scenario=replace(resolved.scenario, solvers=1))).run()
    chi = chi_by_tick(bag, "/robot_a/chi")
    assert sorted(chi) == list(range(160))
    apart = [
        np.abs(np.frombuffer(chi[command.tick]) - command.chi).max() for command in alone.commands
    ]
    assert max(apart) < 1e-9
    # Each message of the bag is replayed as what it is, a part of chi.
    run = read_run(bag)
    question = Question(run, Changes(), run.resolved)
    solver, controller = (replay(question) for replay in (replay_solver, replay_controller))
    assert solver.identical, solver.line()
    assert len(solver.tick) == len(parts)
    assert controller.identical, controller.line()
    assert len(controller.tick) == 160
    whole = joined(run, "robot_b")
    both = whole.stack == "reach_base"
    assert np.isfinite(whole.chi[both]).all()
    assert np.isnan(run.chi["robot_b"].chi[both]).any()
