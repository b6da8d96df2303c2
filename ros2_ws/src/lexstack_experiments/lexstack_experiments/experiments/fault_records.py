"""What a bag says of a run with faults: every message of the contract's topics with its time.

A stranger's messages are marked by their frame and left out; so is what cannot be decoded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from lexstack.types import Vector
from lexstack_bag.errors import BagError
from lexstack_bag.storage.container import Container, RawMessage, find_files
from lexstack_bag.storage.decoder import Decoder
from lexstack_bag.topics import COMMAND, PLAN, PLANT_STATE, SOLUTION, TRANSITION

FORGED = "forged"  # frame_id of what the stranger sends


@dataclass(frozen=True, slots=True)
class State:
    """One state of the plant."""

    at: int  # ns since 1970, when it was recorded
    sender: str
    tick: int
    status: int
    q_star: Vector  # (n,)
    command: Vector  # (n,) in force


@dataclass(frozen=True, slots=True)
class Solved:
    """One chi."""

    at: int  # ns since 1970
    sender: str
    tick: int
    chi: Vector  # (n,)
    beyond: float  # how far it is outside its box
    empty: int  # joints without a box


@dataclass(frozen=True, slots=True)
class Statement:
    """One reason, in /robot_a/transition or /diagnostics."""

    at: int  # ns since 1970
    who: str
    text: str


@dataclass(slots=True)
class Record:
    """All of one or several bags, each list in the order of the messages' sending."""

    states: list[State] = field(default_factory=list)
    commands: list[Solved] = field(default_factory=list)
    solutions: list[Solved] = field(default_factory=list)  # the solver's
    plans: list[int] = field(default_factory=list)  # ns since 1970
    transitions: list[Statement] = field(default_factory=list)
    diagnostics: list[Statement] = field(default_factory=list)
    messages: list[tuple[int, str]] = field(default_factory=list)  # time and bag of each
    unreadable: list[str] = field(default_factory=list)


def read_record(bags: Sequence[Path]) -> Record:
    """Return what bags hold; those that cannot be read are named in it."""
    record = Record()
    for bag in bags:
        try:
            for message in Container(find_files(bag)).messages():
                _add(record, message, str(bag))
        except BagError as error:
            record.unreadable.append(str(error))
    for entries in (record.states, record.commands, record.solutions):
        entries.sort(key=lambda entry: entry.at)
    return record


_DECODE = Decoder()


def _add(record: Record, raw: RawMessage, bag: str) -> None:
    """Take one message."""
    record.messages.append((raw.log_time, bag))
    if raw.topic == PLAN:
        record.plans.append(raw.log_time)
    if raw.topic not in _TAKERS:
        return
    try:
        message = _DECODE(raw)
    except BagError:
        return  # bytes that are no message
    if getattr(message.header, "frame_id", "") == FORGED:
        return
    _TAKERS[raw.topic](record, raw.log_time, message)


def _state(record: Record, at: int, message: Any) -> None:
    if message.sender.startswith("sim_bridge@"):
        values = message.tick, message.status, message.q_star, message.command
        record.states.append(State(at, message.sender, *values))


def _chi(record: Record, at: int, message: Any) -> None:
    ours = {"hqp_controller": record.commands, "stack_solver": record.solutions}
    entries = ours.get(message.sender.partition("@")[0])
    if entries is None:
        return
    chi = np.asarray(message.chi)
    lower, upper = np.asarray(message.lower), np.asarray(message.upper)
    beyond = float(np.maximum(chi - upper, lower - chi).max(initial=0.0))
    entries.append(Solved(at, message.sender, message.tick, chi, beyond, message.empty_bounds))


def _transition(record: Record, at: int, message: Any) -> None:
    if message.tick or message.robots:  # an empty one is a stranger's
        record.transitions.append(Statement(at, message.source, message.reason))


def _diagnostics(record: Record, at: int, message: Any) -> None:
    for status in message.status:
        text = "" if status.message == "ok" else status.message
        record.diagnostics.append(Statement(at, status.name, text))


_TAKERS = {
    PLANT_STATE: _state,
    COMMAND: _chi,
    SOLUTION: _chi,
    TRANSITION: _transition,
    "/diagnostics": _diagnostics,
}
