"""The joint limits in force at each of robot A's ticks: led on from tick to tick as A did."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lexstack_bag.run import ChiStream, PlantStream, Run
from lexstack_core.bounds import JointLimits
from lexstack_core.in_force import LimitOptions, LimitsInForce
from lexstack_core.model import Team
from lexstack_core.stack import build_stack
from lexstack_core.state import RobotState
from lexstack_core.transition.methods import JERK_LIMITED

_AT_REST = " at rest"  # robot A's own stacks, where robot B was lost


def limits_in_force(run: Run, team: Team, commander: str) -> tuple[JointLimits, ...]:
    """Return the limits at every tick of the commander's chi.

    A tick whose plant state was not recorded has those of the tick before. Where several stacks
    are in effect, each on some of the robots, a joint has the tightest limit of them.
    """
    command, stacks = run.chi[commander], limits_of_stacks(run, team)
    if not stacks:
        return (team.limits,) * len(command.tick)
    names = {str(name) for name in command.stack}
    wanted = {name: _tightest(name, stacks, team.limits) for name in names}
    return tuple(_led(run, team, command, [wanted[str(name)] for name in command.stack]))


def limits_of_stacks(run: Run, team: Team) -> dict[str, JointLimits]:
    """Return the limits of the stacks that have their own, by name."""
    stacks = {
        name: build_stack(config, team).limits
        for name, config in run.resolved.stacks.items()
        if config.limits
    }
    return {name: limits for name, limits in stacks.items() if limits is not None}


def _tightest(name: str, stacks: dict[str, JointLimits], own: JointLimits) -> JointLimits:
    """Return what the stacks ask for that a recorded name stands for; they are joined by ' + '."""
    parts = [part.removesuffix(_AT_REST) for part in name.split(" + ")]
    found = [stacks[part] for part in parts if part in stacks]
    if len(found) < 2:
        return found[0] if found else own
    return JointLimits(
        np.maximum.reduce([limits.position_lower for limits in found]),
        np.minimum.reduce([limits.position_upper for limits in found]),
        *(
            np.minimum.reduce([getattr(limits, rate) for limits in found])
            for rate in ("velocity", "acceleration", "jerk")
        ),
    )


def _led(
    run: Run, team: Team, command: ChiStream, wanted: list[JointLimits]
) -> Iterator[JointLimits]:
    """Yield the limits tick by tick, on the way to those that are wanted."""
    scenario = run.resolved.scenario
    options = LimitOptions(run.period, scenario.limit_jerk, scenario.transition.limits_move)
    law, now = LimitsInForce(team.limits, options), team.limits
    states = {state.tick: state for state in _states(run.plant)}
    methods = dict(zip(run.transition.tick.tolist(), run.transition.method.tolist(), strict=True))
    for tick, limits in zip(command.tick.tolist(), wanted, strict=True):
        if tick in states:
            jerk = methods.get(tick, "") in JERK_LIMITED
            now, _ = law.at(states[tick], limits, None, jerk=jerk)
        yield now


def _states(plant: PlantStream) -> Iterator[RobotState]:
    """Yield the plant's states."""
    vectors = (plant.q, plant.v, plant.q_star, plant.command)
    for row in zip(plant.tick.tolist(), plant.stamp.tolist(), *vectors, strict=True):
        yield RobotState(*row)
