"""The nodes' core, fed with what a bag says that the nodes met.

Open loop: the motion is the recorded one, whatever the replayed chi would have made of it. Without
changes the whole state is the recorded one. With changes the command in force is what the replay
itself chose at the tick before, so that its chi goes on from there within the limits; measured
positions and velocities, and q*, stay the recorded ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Protocol

import numpy as np

from lexstack_bag.measures import COMMANDER
from lexstack_bag.replay.outcome import Outcome, joints_of
from lexstack_bag.replay.planner import PLANNER, heard_plans, replay_planner
from lexstack_bag.replay.question import Question
from lexstack_bag.replay.requests import Ask, Cancel, requests_of
from lexstack_bag.replay.states import EVER, Arrivals, States, all_of, begun_at, targets_of
from lexstack_bag.run import ChiStream, Run, SolveStatus
from lexstack_core.build import Parts, build_controller, build_references, build_stack_solver
from lexstack_core.controller import Controller
from lexstack_core.linear import Matrix, Vector
from lexstack_core.references import ReferenceSchedule, Target
from lexstack_core.state import RobotState
from lexstack_core.transition.status import Announcement, SourceSample, SourceSchedule

__all__ = ["REPLAYERS", "Question", "recorded_nodes", "replay_controller", "replay_solver"]

SOLVER = "robot_b"
"""Whose chi robot B sends."""


def replay_solver(question: Question) -> Outcome:
    """Return what robot B answers to the recorded states and requests."""
    run = question.run
    parts = Parts.of(question.resolved)
    solver, references = build_stack_solver(question.resolved, parts), _references(question, parts)
    states, chi = States(run), all_of(run, SOLVER)
    targets, begun = targets_of(run, parts.team), begun_at(chi)
    rows = [row for row, tick in enumerate(chi.tick) if int(tick) in states]
    replayed = np.full((len(rows), parts.team.n), np.nan)
    old, new = question.changes.stacks(question.resolved)
    for place, row in enumerate(rows):
        for target in targets.until(int(begun[row])):
            references.add(target)
        state, stack = states[int(chi.tick[row])], str(chi.stack[row])
        stack = new if new and old in ("", stack) else stack
        answer = solver.solve(stack, parts.team.kinematics(state), references.at(state.stamp))
        replayed[place] = answer.chi if answer.chi.shape == replayed[place].shape else np.nan
        question.progress((place + 1) / len(rows))
    joints = joints_of(parts.team)
    return Outcome(SOLVER, joints, chi.tick[rows], chi.stamp[rows], chi.chi[rows], replayed)


def replay_controller(question: Question) -> Outcome:
    """Return what robot A commands for the recorded states, requests and answers of robot B.

    With changes robot B is replayed as well: it solves what the replayed A asks for. Plans of the
    HTMPC are the recorded ones.
    """
    run, chi = question.run, question.run.chi[COMMANDER]
    parts = Parts.of(question.resolved)
    controller = build_controller(question.resolved, parts)
    states = States(run)
    ticks = states.between(int(chi.tick[0]), int(chi.tick[-1])) if len(chi.tick) else []
    targets, plans = targets_of(run, parts.team), heard_plans(run, parts.team)
    begun = dict(zip(chi.tick.tolist(), begun_at(chi).tolist(), strict=True))
    user = _User(requests_of(run, question.changes, question.resolved))
    source = _LiveSource(question, parts) if question.changes else _RecordedSource(run)
    replayed = np.full((len(ticks), parts.team.n), np.nan)
    sent: Vector | None = None
    for place, tick in enumerate(ticks):
        state = states[tick]
        if question.changes and sent is not None:
            state = replace(state, command=sent)
        now = begun.get(tick, EVER)
        user.speak(controller, source, tick)
        for target in targets.until(now):
            controller.references.add(target)
            source.references.add(target)
        for plan in plans.until(now):
            controller.transition.hear_plan(plan)
        source.answer(controller, state, now)
        sent = replayed[place] = controller.tick(state).chi
        source.hear(controller.transition.take_announcements())
        question.progress((place + 1) / len(ticks))
    return _compared(run, parts, ticks, replayed)


class _User:
    """Asks again what was asked."""

    def __init__(self, requests: Iterable[Ask | Cancel]) -> None:
        """Take the requests in their order."""
        self._waiting = list(requests)

    def speak(self, controller: Controller, source: _Source, tick: int) -> None:
        """Ask what was asked before this tick was served."""
        while self._waiting and self._waiting[0].after < tick:
            request = self._waiting.pop(0)
            if isinstance(request, Cancel):
                controller.transition.cancel()
            else:
                controller.transition.ask(
                    request.stack,
                    request.duration,
                    request.method,
                    request.at_tick,
                    request.robots,
                )
            source.hear(controller.transition.take_announcements())


class _Source(Protocol):
    """Robot B, as the replayed A meets it."""

    references: _Listener

    def hear(self, announcements: Iterable[Announcement]) -> None:
        """Take what A tells it."""
        ...

    def answer(self, controller: Controller, state: RobotState, now: int) -> None:
        """Let A hear what it knows when it begins a tick, at a time [ns]."""
        ...


class _Listener(Protocol):
    """Takes references."""

    def add(self, target: Target) -> None:
        """Take one."""
        ...


class _RecordedSource:
    """Robot B's recorded answers."""

    def __init__(self, run: Run) -> None:
        """Take them from a run."""
        chi = all_of(run, SOLVER)
        self._samples = Arrivals(
            [
                (int(chi.sent[row]), _sample(chi, row))
                for row in range(len(chi.tick))
                if not np.isnan(chi.chi[row]).any()  # A refused it
            ]
        )
        self.references: _Listener = _Nobody()

    def hear(self, announcements: Iterable[Announcement]) -> None:
        """Do nothing: what B answered is known."""

    def answer(self, controller: Controller, _state: RobotState, now: int) -> None:
        """Let A hear all that was sent before it began this tick."""
        for sample in self._samples.until(now):
            controller.transition.hear(sample)


def _slack(chi: ChiStream, row: int) -> float | None:
    """Return what robot B said of level 1, None where it said nothing."""
    known = chi.slacks.shape[1] > 0 and bool(np.isfinite(chi.slacks[row, 0]))
    return float(chi.slacks[row, 0]) if known else None


class _Nobody:
    """Needs no references."""

    def add(self, target: Target) -> None:
        """Do nothing."""


class _LiveSource:
    """Robot B, solving again what the replayed A asks for."""

    def __init__(self, question: Question, parts: Parts) -> None:
        """Build it."""
        self._team = parts.team
        self._stacks = parts.stacks
        self._solver = build_stack_solver(question.resolved, parts)
        self._schedule = SourceSchedule()
        self.references: ReferenceSchedule = _references(question, parts)

    def hear(self, announcements: Iterable[Announcement]) -> None:
        """Know what to solve."""
        for announcement in announcements:
            self._schedule.hear(announcement)

    def answer(self, controller: Controller, state: RobotState, _now: int) -> None:
        """Solve for a state, if a stack is asked for."""
        for wanted in self._schedule.current(state.tick):
            if self._stacks[wanted.stack].planned:
                continue  # the HTMPC's
            kinematics = self._team.kinematics(state)
            references = self.references.at(state.stamp)
            solution = self._solver.solve(wanted.stack, kinematics, references)
            usable = solution.solved and bool(np.isfinite(solution.chi).all())
            slack = float(solution.slacks[0]) if solution.slacks.size else None
            sample = SourceSample(wanted.id, state.tick, solution.chi, usable, slack)
            controller.transition.hear(sample)


def _sample(chi: ChiStream, row: int) -> SourceSample:
    """Return one of B's messages as A took it."""
    return SourceSample(
        int(chi.transition_id[row]),
        int(chi.tick[row]),
        chi.chi[row],
        int(chi.status[row]) == SolveStatus.SOLVED,
        _slack(chi, row),
    )


def _references(question: Question, parts: Parts) -> ReferenceSchedule:
    """Return the scenario's first references."""
    return build_references(question.resolved, parts.team)


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
    planned = any(len(planning.plans.tick) for planning in run.planning.values())
    return tuple(name for name in REPLAYERS if name in found or (name == PLANNER and planned))
