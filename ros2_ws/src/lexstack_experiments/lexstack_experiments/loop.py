"""A scenario and its plant in one process: the closed loop without ROS, tick by tick."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from lexstack.control import Command, Controller, Lockstep
from lexstack.control import Plant as AnyPlant
from lexstack.references import References, Target
from lexstack.robots import Team
from lexstack.transition import Announcement, SourceSample
from lexstack.types import RobotState
from lexstack_config.event_targets import trajectory_targets
from lexstack_config.parts import Parts, build_controller, build_stack_solver
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig, pose_from_config
from lexstack_sim.plant import Plant


@dataclass
class Record:
    """What a run leaves: one entry per tick."""

    states: list[RobotState] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
    references: list[References] = field(default_factory=list)  # as the solver has them
    targets: list[Target] = field(default_factory=list)  # all that were ever added
    sources: dict[int, np.ndarray] = field(default_factory=dict)  # the solver's chi by tick, of all
    b_times: dict[int, float] = field(
        default_factory=dict
    )  # s of wall time of the solver's solve, by tick


class Loop(Lockstep):
    """A scenario in lockstep: its controller, its stack solver and a plant, with a record."""

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
            controller: default: as the nodes build it.
            parts: of the scenario, where they are there already: to make them takes long.
        """
        self.resolved = resolved
        self.parts = parts or Parts.of(resolved)
        super().__init__(
            self.parts.team,
            controller or build_controller(resolved, self.parts),
            build_stack_solver(resolved, self.parts),
            plant or Plant(resolved, self.parts.team, resolved.scenario.seed),
        )
        self.record = Record()
        for event in resolved.scenario.events:
            moving = trajectory_targets(event, self.parts.team, resolved.scenario.references)
            for target in (*targets_of(event, self.parts.team), *moving):
                self.add_target(target)
            ask_switch(self.controller, event, resolved.scenario.rate)

    def run(self, ticks: int | None = None) -> Record:
        """Run for a number of ticks, by default the whole scenario, and return the record."""
        scenario = self.resolved.scenario
        for _ in range(ticks or round(scenario.duration * scenario.rate)):
            self.step()
        return self.record

    def served(self, state: RobotState, references: References, command: Command) -> None:
        """Keep what a tick was, and what became of it."""
        self.record.states.append(state)
        self.record.commands.append(command)
        self.record.references.append(references)

    def add_target(self, target: Target) -> None:
        """Give a new reference to the controller, and to the solver if it does not go by it."""
        self.record.targets.append(target)
        self.controller.references.add(target)
        if self.solver_references is not self.controller.references:
            self.solver_references.add(target)

    def answer(
        self, wanted: Announcement, state: RobotState, references: References
    ) -> SourceSample | None:
        """Return the solver's answer for this tick, and keep it in the record."""
        begun = perf_counter()
        sample = super().answer(wanted, state, references)
        if sample is None:
            return None
        spent = self.record.b_times.get(state.tick, 0.0)
        self.record.b_times[state.tick] = spent + perf_counter() - begun
        chi = self.record.sources.setdefault(state.tick, np.zeros_like(sample.chi))
        for robot in wanted.robots or range(len(self.parts.team.robots)):
            part = self.parts.team.slices[robot]
            chi[part] = sample.chi[part]
        return sample


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
    """Ask the controller for an event's switch, if it has one; ``rate`` in ticks per second."""
    if event.switch:
        tick = round(event.at * rate)
        controller.transition.ask(event.switch, event.duration, "", tick, event.robots)
