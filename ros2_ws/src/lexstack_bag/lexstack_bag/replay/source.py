"""The solver, as a replayed controller meets it: as it was recorded, or solving anew."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

import numpy as np

from lexstack.control import Controller
from lexstack.robots import Team
from lexstack.transition import Announcement, SourceSample, SourceSchedule
from lexstack.types import RobotState
from lexstack_bag.replay.changes import Question
from lexstack_bag.replay.states import Arrivals, all_of
from lexstack_bag.run.partial_chi import robots_of
from lexstack_bag.run.run import ChiStream, Run, SolveStatus
from lexstack_config.parts import Parts, build_stack_solver

SOLVER = "robot_b"
"""Whose chi the solver sends."""


class Source(Protocol):
    """The solver, as the replayed controller meets it."""

    def hear(self, announcements: Iterable[Announcement]) -> None:
        """Take what the controller tells it."""
        ...

    def answer(self, controller: Controller, state: RobotState, now: int) -> None:
        """Let the controller hear what it knows when it begins a tick, at a time [ns]."""
        ...


class RecordedSource:
    """The solver's recorded answers."""

    def __init__(self, run: Run, team: Team) -> None:
        """Take them from a run."""
        samples = _samples(all_of(run, SOLVER), team)
        self._samples = Arrivals(list(samples))

    def hear(self, announcements: Iterable[Announcement]) -> None:
        """Do nothing: what the solver answered is known."""

    def answer(self, controller: Controller, _state: RobotState, now: int) -> None:
        """Let the controller hear all that was sent before it began this tick."""
        for sample in self._samples.until(now):
            controller.transition.hear(sample)


def revision_of(chi: ChiStream, row: int) -> int | None:
    """Return the revision of the references that the solver used, None where it is not known."""
    known = int(chi.references[row]) if len(chi.references) else 0
    return known or None


def _slack(chi: ChiStream, row: int) -> float | None:
    """Return what the solver said of level 1, None where it said nothing."""
    known = chi.slacks.shape[1] > 0 and bool(np.isfinite(chi.slacks[row, 0]))
    return float(chi.slacks[row, 0]) if known else None


class LiveSource:
    """The solver, solving again what the replayed controller asks for."""

    def __init__(self, question: Question, parts: Parts) -> None:
        """Build it."""
        self._team = parts.team
        self._solver = build_stack_solver(question.resolved, parts)
        self._schedule = SourceSchedule()

    def hear(self, announcements: Iterable[Announcement]) -> None:
        """Know what to solve."""
        for announcement in announcements:
            self._schedule.hear(announcement)

    def answer(self, controller: Controller, state: RobotState, _now: int) -> None:
        """Solve for a state, if a stack is asked for."""
        for wanted in self._schedule.current(state.tick):
            if not self._solver.solves(wanted.stack):
                continue  # the HTMPC's
            kinematics = self._team.kinematics(state)
            controller.prepare(state)
            references = controller.references.at(state.stamp)
            controller.transition.hear(self._solver.answer(wanted, kinematics, references))


def _samples(chi: ChiStream, team: Team) -> Iterator[tuple[int, SourceSample]]:
    """Yield the solver's messages as the controller took them, with their sending times [ns]."""
    for row in range(len(chi.tick)):
        robots = robots_of(str(chi.robots[row]), team)
        some = len(robots) < len(team.names)
        values = chi.chi[row]
        if some:
            values, columns = np.zeros(team.n), team.columns(robots)
            values[columns] = chi.chi[row, columns]
        if np.isnan(values).any():
            continue  # A refused it
        yield (
            int(chi.sent[row]),
            SourceSample(
                int(chi.transition_id[row]),
                int(chi.tick[row]),
                values,
                int(chi.status[row]) == SolveStatus.SOLVED,
                _slack(chi, row),
                robots if some else None,
                str(chi.stack[row]),
                revision_of(chi, row),
            ),
        )
