"""The nodes' core, fed with what a bag says that the nodes met.

Open loop: the motion is the recorded one, whatever the replayed chi would have made of it. Without
changes the whole state is the recorded one. With changes the command in force is what the replay
itself chose at the tick before, so that its chi goes on from there within the limits; measured
positions and velocities, and q*, stay the recorded ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from lexstack_bag.container import Progress
from lexstack_bag.measures import COMMANDER
from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.outcome import Outcome, joints_of
from lexstack_bag.replay.requests import Ask, Cancel, requests_of
from lexstack_bag.replay.states import Arrivals, States, begun_at, targets_of
from lexstack_bag.run import Run, SolveStatus
from lexstack_core.build import Parts, build_controller, build_references, build_stack_solver
from lexstack_core.config.resolved import ResolvedScenario
from lexstack_core.controller import Controller
from lexstack_core.linear import Matrix, Vector
from lexstack_core.references import ReferenceSchedule
from lexstack_core.state import RobotState
from lexstack_core.transition.status import SourceSample, SourceSchedule

SOLVER = "robot_b"
"""Whose chi robot B sends."""

_EVER = 2**63 - 1  # ns


@dataclass(frozen=True, slots=True)
class Question:
    """What to replay.

    Attributes:
        run: the recorded run.
        changes: what shall be other than it was.
        resolved: the scenario with the changes made.
        progress: told how much is done, from 0 to 1.
    """

    run: Run
    changes: Changes
    resolved: ResolvedScenario
    progress: Progress = lambda _part: None


def replay_solver(question: Question) -> Outcome:
    """Return what robot B answers to the recorded states and requests."""
    run = question.run
    parts = Parts.of(question.resolved)
    solver, references = build_stack_solver(question.resolved, parts), _references(question, parts)
    targets, begun = targets_of(run, parts.team), begun_at(run.chi[SOLVER])
    states, chi = States(run), run.chi[SOLVER]
    rows = [row for row, tick in enumerate(chi.tick) if int(tick) in states]
    replayed = np.full((len(rows), parts.team.n), np.nan)
    old, new = question.changes.stacks(question.resolved)
    for place, row in enumerate(rows):
        tick, stack = int(chi.tick[row]), str(chi.stack[row])
        for target in targets.until(begun.get(tick, _EVER)):
            references.add(target)
        state = states[tick]
        stack = new if new and old in ("", stack) else stack
        answer = solver.solve(stack, parts.team.kinematics(state), references.at(state.stamp))
        replayed[place] = answer.chi if answer.chi.shape == replayed[place].shape else np.nan
        question.progress((place + 1) / len(rows))
    joints = joints_of(parts.team)
    return Outcome(SOLVER, joints, chi.tick[rows], chi.stamp[rows], chi.chi[rows], replayed)


def replay_controller(question: Question) -> Outcome:
    """Return what robot A commands for the recorded states, requests and answers of robot B.

    With changes robot B is replayed as well: it solves what the replayed A asks for.
    """
    run, chi = question.run, question.run.chi[COMMANDER]
    parts = Parts.of(question.resolved)
    controller = build_controller(question.resolved, parts)
    states = States(run)
    ticks = states.between(int(chi.tick[0]), int(chi.tick[-1])) if len(chi.tick) else []
    targets, begun = targets_of(run, parts.team), begun_at(chi)
    user = _User(requests_of(run, question.changes, question.resolved))
    source = _LiveSource(question, parts) if question.changes else _RecordedSource(run)
    replayed = np.full((len(ticks), parts.team.n), np.nan)
    sent: Vector | None = None
    for place, tick in enumerate(ticks):
        state = states[tick]
        if question.changes and sent is not None:
            state = replace(state, command=sent)
        now = begun.get(tick, _EVER)
        user.speak(controller, tick)
        for target in targets.until(now):
            controller.references.add(target)
            source.references.add(target)
        source.answer(controller, state, now)
        sent = replayed[place] = controller.tick(state).chi
        question.progress((place + 1) / len(ticks))
    return _compared(run, parts, ticks, replayed)


class _User:
    """Asks again what was asked."""

    def __init__(self, requests: Iterable[Ask | Cancel]) -> None:
        """Take the requests in their order."""
        self._waiting = list(requests)
        self._done = 0  # id of the request that a cancellation has made itself

    def speak(self, controller: Controller, tick: int) -> None:
        """Ask what was asked before this tick was served."""
        while self._waiting and self._waiting[0].after < tick:
            request = self._waiting.pop(0)
            if isinstance(request, Cancel):
                answer = controller.transition.cancel()
                self._done = 0 if answer.request is None else answer.request.id
            elif request.id != self._done:
                controller.transition.ask(
                    request.stack, request.duration, request.method, request.at_tick
                )


class _RecordedSource:
    """Robot B's recorded answers."""

    def __init__(self, run: Run) -> None:
        """Take them from a run."""
        chi = run.chi[SOLVER]
        samples = [
            SourceSample(
                int(chi.transition_id[row]),
                int(chi.tick[row]),
                chi.chi[row],
                int(chi.status[row]) == SolveStatus.SOLVED,
            )
            for row in range(len(chi.tick))
            if not np.isnan(chi.chi[row]).any()  # refused by A
        ]
        times = dict(zip(chi.tick.tolist(), chi.sent.tolist(), strict=False))
        self._samples = Arrivals([(times.get(s.tick, 0), s) for s in samples])
        self.references = _Nobody()

    def answer(self, controller: Controller, _state: RobotState, now: int) -> None:
        """Let A hear all that was sent before it began this tick."""
        controller.transition.take_announcements()  # nobody needs them
        for sample in self._samples.until(now):
            controller.transition.hear(sample)


class _Nobody:
    """Needs no references."""

    def add(self, _target: object) -> None:
        """Do nothing."""


class _LiveSource:
    """Robot B, solving again what the replayed A asks for."""

    def __init__(self, question: Question, parts: Parts) -> None:
        """Build it."""
        self._team = parts.team
        self._solver = build_stack_solver(question.resolved, parts)
        self._schedule = SourceSchedule()
        self.references = _references(question, parts)

    def answer(self, controller: Controller, state: RobotState, _now: int) -> None:
        """Solve for a state, if a stack is asked for."""
        for announcement in controller.transition.take_announcements():
            self._schedule.hear(announcement)
        wanted = self._schedule.current(state.tick)
        if wanted is None:
            return
        kinematics = self._team.kinematics(state)
        solution = self._solver.solve(wanted.stack, kinematics, self.references.at(state.stamp))
        usable = solution.solved and bool(np.isfinite(solution.chi).all())
        controller.transition.hear(SourceSample(wanted.id, state.tick, solution.chi, usable))


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
}
"""By the name in the node's topic; whoever adds a node adds its replay here."""
