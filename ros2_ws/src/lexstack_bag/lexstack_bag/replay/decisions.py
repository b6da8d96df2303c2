"""The references that the nodes used: the controller's decisions, or the targets again."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from itertools import pairwise

from lexstack.references import (
    ROUNDING,
    References,
    ReferenceSchedule,
    Setting,
    Target,
    measured,
    targets_between,
)
from lexstack.robots import Team
from lexstack.types import RobotState
from lexstack_bag.replay.changes import Question
from lexstack_bag.replay.states import targets_of
from lexstack_bag.run.run import Run
from lexstack_config.parts import build_references
from lexstack_config.scenario import ScenarioConfig


class Decisions:
    """References for the ticks of a bag, one after another.

    Where the bag has the controller's decisions and no change concerns them, they are taken as they
    are. Else what they were made of is decided on again; in older bags the targets, as they
    arrived.
    """

    def __init__(
        self, question: Question, team: Team, schedule: ReferenceSchedule | None = None
    ) -> None:
        """Take what is in the bag; ``schedule`` is a replayed controller's, else one is made."""
        run = question.run
        self._schedule = schedule or build_references(question.resolved, team)
        before, now = run.resolved.scenario, question.resolved.scenario
        recorded = _given(before) == _given(now)
        self._settings: list[Setting] = list(run.settings) if recorded else []
        self._recorded = bool(self._settings)
        self._targets = targets_of(run, team)
        self._begun = measured(team, run.plant.q[0])
        self._schedule.begin(self._begun)
        self._taken: deque[Target] | None = None
        if run.settings and not recorded:
            self._taken = deque(self._asked(run, team))

    def take(self, state: RobotState, now: int) -> None:
        """Let the schedule know what holds at a state, served at a time [ns]."""
        while self._settings and self._settings[0].at <= state.stamp + ROUNDING:
            self._schedule.timeline.hear(self._settings.pop(0))
        if self._recorded:
            return
        if self._taken is None:
            for target in self._targets.until(now):
                self._schedule.add(target)
            return
        while self._taken and self._taken[0].at <= state.stamp + ROUNDING:
            self._schedule.add(self._taken.popleft())

    def _asked(self, run: Run, team: Team) -> Iterator[Target]:
        """Yield what the recorded decisions were made of, at the ticks where it took effect."""
        first = build_references(run.resolved, team)
        first.begin(self._begun)
        first.decide(run.settings[0].at)
        for before, after in pairwise((*first.take_news(), *run.settings)):
            yield from targets_between(before, after)

    def at(self, state: RobotState, now: int, revision: int | None) -> References:
        """Return the references of a state; in a late answer those that it names."""
        self.take(state, now)
        if self._recorded and revision:
            return self._schedule.timeline.of_revision(revision, state.stamp)
        return self._schedule.at(state.stamp)


def _given(scenario: ScenarioConfig) -> tuple[object, ...]:
    """Return what a scenario says of references."""
    return scenario.ee_target, scenario.base_target, scenario.lead_in
