"""The default scenario with stacks for single robots, and closed loops of it."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np

from lexstack.transition import SourceSample, TransitionState
from lexstack_config.parts import Parts
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiments import relatching_trains
from lexstack_experiments.experiments.relatching_trains import BASES, ROBOTS
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from support.scenario import resolved, team

__all__ = [
    "BASES",
    "ROBOTS",
    "chi_of",
    "loop",
    "parts",
    "silent_for",
    "state_of",
    "with_single_stacks",
]


@cache
def with_single_stacks() -> ResolvedScenario:
    """Return the default scenario with ``NAME_ROBOT`` for each of its stacks and robots."""
    return relatching_trains.with_single_stacks(resolved())


@cache
def parts() -> Parts:
    """Return its robots and stacks, which have no memory."""
    return Parts.of(with_single_stacks())


def loop(**values: Any) -> Loop:
    """Return a closed loop in the ideal plant, with some values of the scenario replaced."""
    base = with_single_stacks()
    scenario = dataclasses.replace(base.scenario, **({"events": ()} | values))
    changed = dataclasses.replace(base, scenario=scenario)
    return Loop(changed, IdealPlant(changed, team()), parts=parts())


def chi_of(run: Loop, robot: str) -> np.ndarray:
    """Return the commands of one robot so far, shape (ticks, n_robot)."""
    part = team().slices[team().index(robot)]
    return np.array([command.chi[part] for command in run.record.commands])


def state_of(run: Loop, robot: str, tick: int = -1) -> TransitionState:
    """Return what the controller told of one robot at a tick."""
    states = run.record.commands[tick].transitions
    (state,) = (state for state in states if robot in state.robots)
    return state


def silent_for(*ids: int) -> Any:
    """Return a link on which the solver's answers for these transitions are lost."""

    def link(sample: SourceSample) -> SourceSample | None:
        return None if sample.transition_id in ids else sample

    return link
