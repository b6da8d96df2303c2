"""A closed loop in one process as the same value that a bag gives: one definition of figures."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.control import Command
from lexstack.references import Target as ScheduledTarget
from lexstack.robots import Team, to_quaternion
from lexstack.types import Matrix, Vector
from lexstack_bag.run.run import (
    ChiStream,
    PlantStream,
    Run,
    SolveStatus,
    Target,
    TransitionStream,
    read_only,
)
from lexstack_experiments.loop import Loop


def recorded(loop: Loop) -> Run:
    """Return what a loop has done so far as a recorded run, for lexstack_bag's measures."""
    record, team = loop.record, loop.parts.team
    return Run(
        path=Path(),
        facts={},
        resolved=loop.resolved,
        plant=_plant(loop),
        chi={"robot_a": _chi(record.commands)},
        transition=_transition(record.commands),
        targets=tuple(part for target in record.targets for part in _targets(target, team)),
        messages={},
        lost=0,
        complete=True,
    )


def _plant(loop: Loop) -> PlantStream:
    """Return the plant's states."""
    states = loop.record.states
    none = np.zeros(len(states), dtype=np.int64)
    return PlantStream(
        tick=_column((state.tick for state in states), np.int64),
        stamp=_column((state.stamp for state in states), np.float64),
        q=_column((state.q for state in states), np.float64),
        v=_column((state.v for state in states), np.float64),
        q_star=_column((state.q_star for state in states), np.float64),
        command=_column((state.command for state in states), np.float64),
        status=none,
        late_ticks=none,
        missing_ticks=none,
    )


def _chi(commands: list[Command]) -> ChiStream:
    """Return robot A's commands."""
    return ChiStream(
        tick=_column((command.tick for command in commands), np.int64),
        stamp=_column((command.stamp for command in commands), np.float64),
        stack=_column((command.stack for command in commands), np.str_),
        transition_id=_column((_newest(command) for command in commands), np.int64),
        chi=_column((command.chi for command in commands), np.float64),
        lower=_column((command.bounds.lower for command in commands), np.float64),
        upper=_column((command.bounds.upper for command in commands), np.float64),
        slacks=_ragged([command.slacks for command in commands]),
        status=_column((_status(command) for command in commands), np.int64),
        empty_bounds=_column((command.bounds.empty for command in commands), np.int64),
        solve_time=_column((command.solve_time for command in commands), np.float64),
        reason=_column((command.fallback for command in commands), np.str_),
    )


def _transition(commands: list[Command]) -> TransitionStream:
    """Return where the transition stood."""
    pairs = [(command, state) for command in commands for state in command.transitions]
    told = [state for _, state in pairs]
    return TransitionStream(
        tick=_column((command.tick for command, _ in pairs), np.int64),
        stamp=_column((command.stamp for command, _ in pairs), np.float64),
        id=_column((state.id for state in told), np.int64),
        from_stack=_column((state.from_stack for state in told), np.str_),
        to_stack=_column((state.to_stack for state in told), np.str_),
        source=_column((state.source.value for state in told), np.str_),
        method=_column((state.method for state in told), np.str_),
        phase=_column((state.phase.value for state in told), np.int64),
        alpha=_column((state.alpha for state in told), np.float64),
        duration=_column((state.duration for state in told), np.float64),
        gap=_column((state.gap for state in told), np.float64),
        reason=_column((state.reason for state in told), np.str_),
        robots=_column((" ".join(state.robots) for state in told), np.str_),
    )


def _targets(target: ScheduledTarget, team: Team) -> Iterable[Target]:
    """Yield what one target says, as messages would."""
    name = team.names[target.robot]
    if target.ee is not None:
        quaternion = to_quaternion(target.ee.rotation)
        yield Target(name, "ee", target.at, target.ee.position, quaternion)
    if target.base is not None:
        x, y, yaw = target.base
        half = np.array([0.0, 0.0, np.sin(yaw / 2.0), np.cos(yaw / 2.0)])
        yield Target(name, "base", target.at, np.array([x, y, 0.0]), half)


def _newest(command: Command) -> int:
    """Return the id of the newest of a command's transitions."""
    return max(state.id for state in command.transitions)


def _status(command: Command) -> SolveStatus:
    """Return how a command came about."""
    return SolveStatus.FALLBACK if command.fallback else SolveStatus.SOLVED


def _ragged(rows: list[Vector]) -> Matrix:
    """Return vectors as rows, nan at the ends of the shorter ones."""
    result = np.full((len(rows), max((row.size for row in rows), default=0)), np.nan)
    for line, row in zip(result, rows, strict=True):
        line[: row.size] = row
    return read_only(result)


def _column(values: Iterable[Any], kind: type) -> NDArray[Any]:
    """Return values, one per tick, as a read-only array."""
    return read_only(np.array(list(values), dtype=kind))
