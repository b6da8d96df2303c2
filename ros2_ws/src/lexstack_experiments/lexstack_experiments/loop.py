"""Core and plant in one process: the closed loop without ROS, tick by tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Protocol

import numpy as np

from lexstack.control import Command, Controller
from lexstack.hqp import Solution
from lexstack.references import References, Target
from lexstack.robots import Kinematics, Team
from lexstack.transition import Announcement, SourceSample, SourceSchedule
from lexstack.types import RobotState, Vector
from lexstack_config.parts import Parts, build_controller, build_stack_solver
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig, pose_from_config
from lexstack_sim.plant import Plant

AskB = Callable[[Announcement, RobotState, References], SourceSample | None]
"""Robot B's answer for a tick, or an earlier one, or none."""

Link = Callable[[SourceSample], SourceSample | None]
"""What robot A hears when robot B sends: the message, another one, or nothing."""


class AnyPlant(Protocol):
    """What the loop needs of a plant."""

    def state(self) -> RobotState:
        """Return the present state."""
        ...

    def step(self, chi: Vector | None) -> RobotState:
        """Advance by one tick under a command and return the new state."""
        ...


@dataclass
class Record:
    """What a run leaves: one entry per tick."""

    states: list[RobotState] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
    references: list[References] = field(default_factory=list)  # as robot B has them
    targets: list[Target] = field(default_factory=list)  # all that were ever added
    sources: dict[int, np.ndarray] = field(default_factory=dict)  # robot B's chi by tick, of all
    b_times: dict[int, float] = field(default_factory=dict)  # s of wall time of B's solve, by tick


class Loop:
    """Robot A, robot B and the plant, as the processes run them, in lockstep."""

    def __init__(
        self,
        resolved: ResolvedScenario,
        plant: AnyPlant | None = None,
        controller: Controller | None = None,
        parts: Parts | None = None,
    ) -> None:
        """Build all parts and schedule the scenario's events.

        Args:
            resolved: the scenario.
            plant: default: MuJoCo's.
            controller: robot A; default: as the nodes build it.
            parts: of the scenario, where they are there already: to make them takes long.
        """
        self.resolved = resolved
        self.parts = parts or Parts.of(resolved)
        self.plant: AnyPlant = plant or Plant(resolved, self.parts.team, resolved.scenario.seed)
        self.controller = controller or build_controller(resolved, self.parts)
        # Robot B goes by robot A's decisions; another schedule shows what happens if it does not.
        self.references_b = self.controller.references
        self.solver_b = build_stack_solver(resolved, self.parts)
        self.schedule = SourceSchedule()
        self._seen_by_b: Kinematics | None = None
        self.record = Record()
        # Whether robot B answers at a tick, how it is asked, and what A hears of its answer;
        # experiments replace them.
        self.b_answers: Callable[[int], bool] = lambda _tick: True
        self.ask_b: AskB = self._ask_b
        self.link: Link = lambda sample: sample
        for event in resolved.scenario.events:
            for target in targets_of(event, self.parts.team):
                self.add_target(target)
            ask_switch(self.controller, event, resolved.scenario.rate)

    def run(self, ticks: int | None = None) -> Record:
        """Run for a number of ticks, by default the whole scenario, and return the record."""
        scenario = self.resolved.scenario
        for _ in range(ticks or round(scenario.duration * scenario.rate)):
            self.step()
        return self.record

    def step(self) -> Command:
        """Serve one tick: B's chi if it is asked for, A's command, the plant's step."""
        state = self.plant.state()
        for announcement in self.controller.transition.take_announcements():
            self.schedule.hear(announcement)
        self.controller.prepare(state)
        references = self.references_b.at(state.stamp)
        wanted = self.schedule.current(state.tick)
        if wanted and self.b_answers(state.tick):
            for announcement in wanted:
                sample = self.ask_b(announcement, state, references)
                heard = None if sample is None else self.link(sample)
                if heard is not None:
                    self.controller.transition.hear(heard)
        command = self.controller.tick(state)
        self.record.states.append(state)
        self.record.commands.append(command)
        self.record.references.append(references)
        self.plant.step(command.chi)
        return command

    def add_target(self, target: Target) -> None:
        """Give a new reference to both controllers, as a message would."""
        self.record.targets.append(target)
        self.controller.references.add(target)
        if self.references_b is not self.controller.references:
            self.references_b.add(target)

    def _ask_b(
        self, wanted: Announcement, state: RobotState, references: References
    ) -> SourceSample:
        """Return robot B's answer for this tick, and keep it in the record."""
        begun = perf_counter()
        if self._seen_by_b is None or self._seen_by_b.state is not state:
            self._seen_by_b = self.parts.team.kinematics(state)
        solution = self.solver_b.solve(wanted.stack, self._seen_by_b, references)
        spent = self.record.b_times.get(state.tick, 0.0)
        self.record.b_times[state.tick] = spent + perf_counter() - begun
        chi = self.record.sources.setdefault(state.tick, np.zeros_like(solution.chi))
        for robot in wanted.robots or range(len(self.parts.team.robots)):
            part = self.parts.team.slices[robot]
            chi[part] = solution.chi[part]
        return sample_of(wanted, state.tick, solution, references.revision)


def sample_of(
    wanted: Announcement, tick: int, solution: Solution, revision: int | None = None
) -> SourceSample:
    """Return a solution as robot B sends it; ``revision`` is that of its references."""
    slack = float(solution.slacks[0])
    return SourceSample(wanted.id, tick, solution.chi, solution.solved, slack, revision=revision)


def targets_of(event: EventConfig, team: Team) -> list[Target]:
    """Return an event's new references."""
    poses = [
        Target(event.at, team.index(name), ee=pose_from_config(pose))
        for name, pose in event.ee_target.items()
    ]
    bases = [
        Target(event.at, team.index(name), base=np.array(base))
        for name, base in event.base_target.items()
    ]
    return poses + bases


def ask_switch(controller: Controller, event: EventConfig, rate: float) -> None:
    """Ask robot A for an event's switch, if it has one; ``rate`` in ticks per second."""
    if event.switch:
        tick = round(event.at * rate)
        controller.transition.ask(event.switch, event.duration, "", tick, event.robots)
