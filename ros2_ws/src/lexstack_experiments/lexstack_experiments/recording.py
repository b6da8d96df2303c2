"""A closed loop in one process as the same value that a bag gives: one definition of figures."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

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

T = TypeVar("T", PlantStream, ChiStream, TransitionStream)
_KINDS = {"Integers": np.int64, "Strings": np.str_, "Names": np.str_}


def recorded(loop: Loop) -> Run:
    """Return what a loop has done so far as a recorded run, for lexstack_bag's measures."""
    record, team = loop.record, loop.parts.team
    return Run(
        path=Path(),
        provenance={},
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
    none = [0] * len(states)
    return _stream(PlantStream, states, status=none, late_ticks=none, missing_ticks=none)


def _chi(commands: list[Command]) -> ChiStream:
    """Return the controller's commands."""
    return _stream(
        ChiStream,
        commands,
        transition_id=[max(state.id for state in c.transitions) for c in commands],
        lower=[command.bounds.lower for command in commands],
        upper=[command.bounds.upper for command in commands],
        slacks=_ragged([command.slacks for command in commands]),
        status=[SolveStatus.FALLBACK if c.fallback else SolveStatus.SOLVED for c in commands],
        empty_bounds=[command.bounds.empty for command in commands],
        reason=[command.fallback for command in commands],
    )


def _transition(commands: list[Command]) -> TransitionStream:
    """Return where the transition stood."""
    pairs = [(command, state) for command in commands for state in command.transitions]
    return _stream(
        TransitionStream,
        [state for _, state in pairs],
        tick=[command.tick for command, _ in pairs],
        stamp=[command.stamp for command, _ in pairs],
        source=[state.source.value for _, state in pairs],
        robots=[" ".join(state.robots) for _, state in pairs],
    )


def _stream(kind: type[T], rows: Sequence[Any], **columns: Any) -> T:
    """Return a stream with these columns, and the rows' attributes of the others' names."""
    for field in dataclasses.fields(kind):
        if field.name not in columns and field.default_factory is dataclasses.MISSING:
            columns[field.name] = [getattr(row, field.name) for row in rows]
    kinds = {
        field.name: _KINDS.get(str(field.type), np.float64) for field in dataclasses.fields(kind)
    }
    return kind(**{n: read_only(np.array(v, dtype=kinds[n])) for n, v in columns.items()})


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


def _ragged(rows: list[Vector]) -> Matrix:
    """Return vectors as rows, nan at the ends of the shorter ones."""
    result = np.full((len(rows), max((row.size for row in rows), default=0)), np.nan)
    for line, row in zip(result, rows, strict=True):
        line[: row.size] = row
    return result
