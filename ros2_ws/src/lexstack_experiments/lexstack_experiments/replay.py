"""What the controller met in a closed loop, to be met again by another controller, tick by tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from lexstack.control import Command, Controller
from lexstack.transition import Source, SourceSample
from lexstack.types import RobotState, Vector
from lexstack_config.parts import build_team
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop, ask_switch, targets_of
from lexstack_experiments.measuring import no_collection


@dataclass(frozen=True, slots=True)
class Tape:
    """A closed loop as the controller saw it: states, messages, and what it answered."""

    resolved: ResolvedScenario
    states: tuple[RobotState, ...]
    samples: dict[int, list[SourceSample]]  # by tick
    commands: tuple[Command, ...]

    @classmethod
    def of(cls, resolved: ResolvedScenario) -> Tape:
        """Record a scenario in the ideal plant."""
        return cls.of_loop(Loop(resolved, IdealPlant(resolved, build_team(resolved))))

    @classmethod
    def of_loop(cls, loop: Loop) -> Tape:
        """Record a loop that has not run yet."""
        samples: dict[int, list[SourceSample]] = {}

        def keep(sample: SourceSample) -> SourceSample:
            samples.setdefault(sample.tick, []).append(sample)
            return sample

        loop.link = keep
        record = loop.run()
        return cls(loop.resolved, tuple(record.states), samples, tuple(record.commands))

    @property
    def blending(self) -> list[bool]:
        """Whether the controller followed a source, tick by tick."""
        return [c.transition.source is not Source.NONE for c in self.commands]

    def play(
        self,
        controller: Controller,
        watch: Callable[[int], None] = lambda _tick: None,
        clock: Callable[[], float] = perf_counter,
    ) -> tuple[Vector, float]:
        """Give all ticks to a new controller of the same scenario, with garbage collection off.

        Args:
            controller: that has not served a tick yet.
            watch: called after every tick, outside of the time measured.
            clock: by which a tick is measured [s]; default: the wall's.

        Returns:
            The time of every tick [s], and the largest difference of its chi from the tape.
        """
        team = build_team(self.resolved)
        for event in self.resolved.scenario.events:
            for target in targets_of(event, team):
                controller.references.add(target)
            ask_switch(controller, event, self.resolved.scenario.rate)
        times, differences = np.empty(len(self.states)), np.empty(len(self.states))
        with no_collection():
            for k, state in enumerate(self.states):
                controller.transition.take_announcements()
                for sample in self.samples.get(state.tick, ()):
                    controller.transition.hear(sample)
                begun = clock()
                command = controller.tick(state)
                times[k] = clock() - begun
                differences[k] = np.abs(command.chi - self.commands[k].chi).max()
                watch(k)
        return times, float(differences.max())
