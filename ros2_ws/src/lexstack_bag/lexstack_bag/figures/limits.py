"""The joint limits in force at each of the controller's ticks: led on as it did."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lexstack.limits import JointLimits, LimitOptions, LimitsInForce
from lexstack.robots import Team
from lexstack.tasks import AT_REST, build_limits
from lexstack.transition import JERK_LIMITED
from lexstack.types import RobotState
from lexstack_bag.run.run import ChiStream, PlantStream, Run, TransitionPhase

_JOINED = " + "  # between the names of several stacks
_NOT_YET = (TransitionPhase.REQUESTED, TransitionPhase.PREPARING)  # the stack is still to come


def limits_in_force(run: Run, team: Team, commander: str) -> tuple[JointLimits, ...]:
    """Return the limits at every tick of the commander's chi.

    A tick whose plant state was not recorded has those of the tick before.
    """
    command, stacks = run.chi[commander], limits_of_stacks(run, team)
    if not stacks:
        return (team.limits,) * len(command.tick)
    in_effect = list(_stacks_in_effect(run, command))
    wanted = {names: _joined(names, stacks, team) for names in set(in_effect)}
    return tuple(_led(run, team, command, [wanted[names] for names in in_effect]))


def limits_of_stacks(run: Run, team: Team) -> dict[str, JointLimits]:
    """Return the limits of the stacks that have their own, by name."""
    stacks = {name: build_limits(config, team) for name, config in run.resolved.stacks.items()}
    return {name: limits for name, limits in stacks.items() if limits is not None}


def _stacks_in_effect(run: Run, command: ChiStream) -> Iterator[tuple[str, ...]]:
    """Yield the stack of each robot, tick by tick.

    Chi names all stacks in effect; which robot is on which of several, the transitions tell.
    """
    robots, status = run.robots, run.transition
    rows: dict[int, list[int]] = {}
    for row in np.flatnonzero(~np.isin(status.phase, _NOT_YET)).tolist():
        rows.setdefault(int(status.tick[row]), []).append(row)
    now = dict.fromkeys(robots, "")
    for tick, name in zip(command.tick.tolist(), command.stack.tolist(), strict=True):
        if _JOINED not in name:
            now = dict.fromkeys(robots, name.removesuffix(AT_REST))
        elif len(status.robots):
            for row in rows.get(tick, []):
                stack = str(status.to_stack[row]).removesuffix(AT_REST)
                now |= dict.fromkeys(str(status.robots[row]).split(), stack)
        yield tuple(now[robot] for robot in robots)


def _joined(names: tuple[str, ...], stacks: dict[str, JointLimits], team: Team) -> JointLimits:
    """Return the limits of all joints, given the stack of each robot."""
    found = [stacks.get(name, team.limits) for name in names]
    if all(limits is found[0] for limits in found):
        return found[0]
    return team.limits.replaced(zip(team.slices, found, strict=True))


def _led(
    run: Run, team: Team, command: ChiStream, wanted: list[JointLimits]
) -> Iterator[JointLimits]:
    """Yield the limits tick by tick, on the way to those that are wanted."""
    scenario = run.resolved.scenario
    options = LimitOptions(run.period, scenario.limit_jerk, scenario.transition.limits_move)
    law, now = LimitsInForce(team.limits, options, team.joint_positions), team.limits
    states = {state.tick: state for state in _states(run.plant)}
    limited = np.isin(run.transition.method, tuple(JERK_LIMITED))
    with_jerk = set(run.transition.tick[limited].tolist())
    for tick, limits in zip(command.tick.tolist(), wanted, strict=True):
        if tick in states:
            now, _ = law.at(states[tick], limits, None, jerk=tick in with_jerk)
        yield now


def _states(plant: PlantStream) -> Iterator[RobotState]:
    """Yield the plant's states."""
    vectors = (plant.q, plant.v, plant.q_star, plant.command)
    for row in zip(plant.tick.tolist(), plant.stamp.tolist(), *vectors, strict=True):
        yield RobotState(*row)
