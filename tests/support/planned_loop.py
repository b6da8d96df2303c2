"""The closed loop with sequences: the HTMPC plans, the controller follows, all in one process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc import (
    ARCHITECTURES,
    Change,
    Progress,
    SequenceRunner,
    SequenceTask,
    plans_of,
    tasks_of,
)
from lexstack.tasks import plan_stack
from lexstack.transition import HeardPlan
from lexstack.types import RobotState
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import SequenceChangeConfig
from lexstack_experiments.loop import AnyPlant, Loop

_AHEAD = 2  # plans between the end of a sequence and the tick at which the controller goes back
_NS = 1e9

PlanLink = Callable[[HeardPlan], HeardPlan | None]
"""What the controller hears when the HTMPC sends a plan: the plan, another one, or nothing."""


@dataclass
class _Job:
    """A sequence to be executed.

    Attributes:
        name: in the scenario.
        robot: its place in the team.
        tasks: all rounds.
        architecture: ht or st.
        begin: tick of the first plan.
        end: tick of the last plan, None: not known yet.
    """

    name: str
    robot: int
    tasks: tuple[SequenceTask, ...]
    architecture: str
    begin: int
    end: int | None = None
    progress: list[Progress] = field(default_factory=list)


class PlannedLoop(Loop):
    """The controller, the solver, the HTMPC and the plant in lockstep, as the processes run them.

    Attributes:
        plan_link: what the controller hears of the plans; experiments replace it.
    """

    def __init__(self, resolved: ResolvedScenario, plant: AnyPlant | None = None) -> None:
        """Build all parts; schedule the scenario's events, those of its sequences too."""
        super().__init__(resolved, plant)
        scenario = resolved.scenario
        self._every = scenario.htmpc.ticks(scenario.rate)
        self._runners: dict[int, SequenceRunner] = {}
        self._jobs: list[_Job] = []
        self._changes: list[tuple[int, SequenceChangeConfig]] = []
        self.plan_link: PlanLink = lambda plan: plan
        self.plans = self._plans_of
        for event in resolved.scenario.events:
            tick = round(event.at * scenario.rate)
            for name in event.execute:
                self._execute(name, tick)
            self._changes += [(tick, change) for change in event.changes]

    def progress(self, name: str) -> list[Progress]:
        """Return what was told after each plan of a sequence of the scenario."""
        return next(job.progress for job in self._jobs if job.name == name)

    def _plans_of(self, state: RobotState) -> list[HeardPlan]:
        """Return the plans that are due before a tick."""
        if state.tick % self._every:
            return []
        # As a message tells it: to the nanosecond.
        return self._plan(replace(state, stamp=round(_NS * state.stamp) / _NS))

    def _execute(self, name: str, tick: int) -> None:
        """Ask the controller to follow the plans of a sequence from a tick on."""
        config = self.resolved.scenario.sequences[name]
        robot = self.parts.team.index(config.robot)
        begin = tick - tick % self._every
        job = _Job(name, robot, tasks_of(config), config.architecture, begin)
        self._jobs.append(job)
        self._ask(plan_stack(config.robot), robot, tick)
        if robot not in self._runners:
            scenario = self.resolved.scenario
            parameters = self.resolved.htmpc[scenario.htmpc.parameters]
            self._runners[robot] = SequenceRunner(
                self.parts.team, robot, parameters, scenario.transition.duration
            )

    def _plan(self, state: RobotState) -> list[HeardPlan]:
        """Plan for every robot with a sequence under way."""
        due = [change for tick, change in self._changes if tick <= state.tick]
        self._changes = [entry for entry in self._changes if entry[0] > state.tick]
        for change in due:
            robot = self.parts.team.index(change.robot)
            self._runners[robot].change(Change(change.change, change.task, change.points), state)
        under_way = [
            job
            for job in self._jobs
            if job.begin <= state.tick and (job.end is None or state.tick <= job.end)
        ]
        plans = [self._plan_one(job, state) for job in under_way]
        return [plan for plan in plans if plan is not None]

    def _plan_one(self, job: _Job, state: RobotState) -> HeardPlan | None:
        """Return one plan as it arrives; at the sequence's end ask the controller to go back."""
        runner = self._runners[job.robot]
        if state.tick == job.begin:
            runner.begin(job.tasks, ARCHITECTURES[job.architecture], state)
        progress = runner.step(state, plans_of(self._runners))
        job.progress.append(progress)
        plan = progress.plan
        times = np.round(_NS * plan.step * np.arange(len(plan.v))) / _NS
        heard = self.plan_link(HeardPlan(job.robot, state.tick, times, plan.v))
        if progress.sequence.done and job.end is None:
            job.end = state.tick + _AHEAD * self._every
            self._ask(self.resolved.scenario.initial_stack, job.robot, job.end)
        if state.tick == job.end:
            runner.end()
        return heard

    def _ask(self, stack: str, robot: int, tick: int) -> None:
        """Ask the controller for a stack of one robot; raises InputError where it refuses."""
        name, duration = self.parts.team.names[robot], self.resolved.scenario.transition.duration
        answer = self.controller.transition.ask(stack, duration, "", tick, [name])
        if not answer.accepted:
            raise InputError(answer.message)
