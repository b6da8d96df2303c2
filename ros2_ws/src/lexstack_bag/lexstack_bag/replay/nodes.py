"""The nodes' library code, fed with what a bag says that the nodes met.

Open loop: the motion is the recorded one, whatever the replayed chi would have made of it. Without
changes the whole state is the recorded one. With changes the command in force is what the replay
itself chose at the tick before, so that its chi goes on from there within the limits; measured
positions and velocities, and q*, stay the recorded ones.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lexstack.tasks import Stack
from lexstack.transition import Columns
from lexstack.types import Matrix
from lexstack_bag.figures.series import COMMANDER
from lexstack_bag.replay.changes import Question
from lexstack_bag.replay.decisions import Decisions
from lexstack_bag.replay.loop import ReplayLoop
from lexstack_bag.replay.outcome import Outcome, joints_of
from lexstack_bag.replay.planner import PLANNER, replay_planner
from lexstack_bag.replay.source import SOLVER, revision_of
from lexstack_bag.replay.states import States, all_of, begun_at
from lexstack_bag.run.partial_chi import robots_of
from lexstack_bag.run.run import Run
from lexstack_config.parts import Parts, build_stack_solver

__all__ = ["REPLAYERS", "Question", "recorded_nodes", "replay_controller", "replay_solver"]


def replay_solver(question: Question) -> Outcome:
    """Return what the solver answers to the recorded states and requests."""
    run = question.run
    parts = Parts.of(question.resolved, every=True)
    solver = build_stack_solver(question.resolved, parts)
    states, chi = States(run), all_of(run, SOLVER)
    decisions, begun = Decisions(question, parts.team), begun_at(chi)
    rows = [row for row, tick in enumerate(chi.tick) if int(tick) in states]
    replayed = np.full((len(rows), parts.team.n), np.nan)
    old, new = question.changes.stacks(question.resolved)
    for place, row in enumerate(rows):
        state, stack = states[int(chi.tick[row])], str(chi.stack[row])
        stack = new if new and old in ("", stack) else stack
        asked, mine = _asked(parts, stack, str(chi.robots[row]))
        references = decisions.at(state, int(begun[row]), revision_of(chi, row))
        answer = solver.solve(asked, parts.team.kinematics(state), references)
        if answer.chi.shape == replayed[place].shape:
            replayed[place, mine] = answer.chi[mine]
        question.progress((place + 1) / len(rows))
    joints = joints_of(parts.team)
    return Outcome(SOLVER, joints, chi.tick[rows], chi.stamp[rows], chi.chi[rows], replayed)


def _asked(parts: Parts, stack: str, names: str) -> tuple[Stack, Columns]:
    """Return what the solver, or one of several, solved of a stack, and the joints that it sent."""
    robots, everyone = robots_of(names, parts.team), len(parts.team.names)
    known = parts.stacks[stack]
    if len(robots) == everyone:
        return known, slice(0, parts.team.n)
    return known.of(robots), parts.team.columns(robots)


def replay_controller(question: Question) -> Outcome:
    """Return what the controller commands for the recorded states, requests and solver's answers.

    With changes the solver is replayed as well: it solves what the replayed controller asks for.
    Plans of the HTMPC are the recorded ones.
    """
    run, parts = question.run, Parts.of(question.resolved, every=True)
    loop = ReplayLoop(question, parts)
    replayed = np.full((len(loop.ticks), parts.team.n), np.nan)
    for place in range(len(loop.ticks)):
        replayed[place] = loop.step().chi
        question.progress((place + 1) / len(loop.ticks))
    return _compared(run, parts, loop.ticks, replayed)


def _compared(run: Run, parts: Parts, ticks: list[int], replayed: Matrix) -> Outcome:
    """Return the ticks whose command is in the bag, beside what was replayed."""
    chi = run.chi[COMMANDER]
    places = {tick: place for place, tick in enumerate(ticks)}
    rows = [row for row, tick in enumerate(chi.tick) if int(tick) in places]
    found = replayed[[places[int(tick)] for tick in chi.tick[rows]]]
    joints = joints_of(parts.team)
    return Outcome(COMMANDER, joints, chi.tick[rows], chi.stamp[rows], chi.chi[rows], found)


REPLAYERS: dict[str, Callable[[Question], Outcome]] = {
    COMMANDER: replay_controller,
    SOLVER: replay_solver,
    PLANNER: replay_planner,
}
"""By the name in the node's topic; whoever adds a node adds its replay here."""


def recorded_nodes(run: Run) -> tuple[str, ...]:
    """Return the nodes of which a bag has something to replay."""
    found = [name for name, chi in run.chi.items() if len(chi.tick)]
    planned = any(len(plan_topics.plans.tick) for plan_topics in run.plan_topics.values())
    return tuple(name for name in REPLAYERS if name in found or (name == PLANNER and planned))
