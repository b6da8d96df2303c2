"""The references that the nodes used: the controller's decisions, or the targets again."""

from __future__ import annotations

from lexstack.references import References, ReferenceSchedule, Setting, measured
from lexstack.robots import Team
from lexstack.types import RobotState
from lexstack_bag.replay.changes import Question
from lexstack_bag.replay.states import targets_of
from lexstack_config.parts import build_references
from lexstack_config.scenario import ScenarioConfig


class Decisions:
    """References for the ticks of a bag, one after another.

    Where the bag has the controller's decisions and no change concerns them, they are taken as they
    are. Else the targets are decided on again, as they arrived.
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
        self._schedule.begin(measured(team, run.plant.q[0]))

    def take(self, state: RobotState, now: int) -> None:
        """Let the schedule know what holds at a state, served at a time [ns]."""
        while self._settings and self._settings[0].at <= state.stamp + 1e-9:
            self._schedule.timeline.hear(self._settings.pop(0))
        if self._recorded:
            return
        for target in self._targets.until(now):
            self._schedule.add(target)

    def at(self, state: RobotState, now: int, revision: int | None) -> References:
        """Return the references of a state; in a late answer those that it names."""
        self.take(state, now)
        if self._recorded and revision:
            return self._schedule.timeline.of_revision(revision, state.stamp)
        return self._schedule.at(state.stamp)


def _given(scenario: ScenarioConfig) -> tuple[object, ...]:
    """Return what a scenario says of references."""
    return scenario.ee_target, scenario.base_target, scenario.lead_in
