"""What came of a fault: limits kept, order kept, who told it, and how long all took."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from lexstack.types import PlantStatus, Vector
from lexstack_bag.figures.limits import JointLimits
from lexstack_experiments.experiments.fault_records import Record, Solved, State, Statement

_NS = 1e-9
_AS_TOLD = (PlantStatus.FOLLOWING, PlantStatus.PAUSED)
_AFTER = 2_000_000_000  # ns after the end of a case in which a reason may still come

# Who must tell what, by the process that fails: in the transition (only while the controller
# depends on it), and in diagnostics. A fault with a dead controller is told by the plant.
_TRANSITION = {
    ("stack_solver", "blending"): "the solver",
    ("stack_solver", "following"): "the solver",
    ("htmpc", "sequence"): "MPC",
    **{
        # What the controller says first of its absence may be that the solver's chi did not come.
        ("hqp_controller", phase): "the controller (began|was away)|the solver"
        for phase in ("idle", "blending", "following", "sequence")
    },
}
_DIAGNOSTICS = {
    "stack_solver": "stack_solver is silent|the solver",
    "htmpc": "htmpc is silent|MPC",
    "hqp_controller": "no command comes|hqp_controller is silent|the controller",
    "sim_bridge": "/plant/state is silent|sim_bridge is silent",
    "recorder": "recorder is silent",
    "slow": "the solver",
    "disk": "the bag ends here",
    "message": "refused: ",
}
_OF_PROCESSES = ("kill", "stop", "cut")
_ON_HOST = {"robot_a": "hqp_controller", "robot_b": "stack_solver"}
SILENT = ("garbage bytes", "replayed")
"""Messages of which nobody has to tell: dropped by the middleware, or merely old."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one case; times in s, None: it was not seen.

    Attributes:
        case: its name.
        acceleration: largest change of the command in force over its limit.
        velocity: largest command in force over its limit.
        beyond: how far a command of the controller was outside its box, and empty boxes as 1 each.
        reordered: messages of a sender whose tick is not above the one before.
        ticks: of the plant that were recorded.
        detected: from the fault to the first sign of it.
        told: from the fault to the reason in diagnostics.
        reason: in /robot_a/transition.
        complaint: in /diagnostics.
        missing: what had to be told and was not.
        recovered: from the restart, or from the end of the fault, until it served again.
        away: how long the plant held or braked.
        rejoined: whether the solver served a switch afterwards.
        answers: to a flood of requests.
    """

    case: str
    acceleration: float
    velocity: float
    beyond: float
    reordered: int
    ticks: int
    detected: float | None
    told: float | None
    reason: str
    complaint: str
    missing: str
    recovered: float | None
    away: float
    rejoined: bool
    answers: int


def outcome(event: dict[str, Any], record: Record, limits: JointLimits, dt: float) -> Outcome:
    """Return what came of a case; ``record`` holds the bags of its run, ``dt`` is a tick [s]."""
    begun, ended = event["begun"], event["ended"]
    fault, what, phase = split(event["case"])
    what = _ON_HOST.get(what, what)
    states = [state for state in record.states if begun - _AFTER // 2 <= state.at <= ended]
    commands = [chi for chi in record.commands if begun <= chi.at <= ended]
    wanted = _TRANSITION.get((what, phase), "") if fault in _OF_PROCESSES else ""
    slow = fault == "slow" and float(what.split()[0]) > _TOLERATED
    if slow:
        wanted = _TRANSITION["stack_solver", "blending"]
    key = what if fault in _OF_PROCESSES else fault
    harmless = what in SILENT or (fault == "slow" and not slow)
    needed = "" if harmless else _DIAGNOSTICS.get(key, "")
    if phase == "idle" and key in ("stack_solver", "htmpc"):
        needed = f"{key} is silent"  # the controller has nothing else to tell
    window = begun, ended + _AFTER
    reason = first_statement(record.transitions, window, wanted)
    complaint = first_statement(record.diagnostics, window, needed)
    missing = [name for name, pattern, found in (
        ("transition", wanted, reason), ("diagnostics", needed, complaint)
    ) if pattern and found is None]  # fmt: skip
    signs = [found.at for found in (reason, complaint) if found is not None]
    signs += [s.at for s in states if s.at > begun and s.status not in _AS_TOLD][:1]
    return Outcome(
        event["case"],
        peak_acceleration(states, limits.acceleration, dt),
        max((float((np.abs(s.command) / limits.velocity).max()) for s in states), default=0.0),
        max((chi.beyond + chi.empty for chi in commands), default=0.0),
        out_of_order(states) + out_of_order(commands, _beginnings(record.states)),
        len(states),
        _seconds(begun, min(signs, default=None)),
        _seconds(begun, None if complaint is None else complaint.at),
        "" if reason is None else reason.text,
        "" if complaint is None else f"{complaint.who}: {complaint.text}",
        ", ".join(missing),
        _seconds(event["healed"], _served(event, what, record)),
        sum(s.status not in _AS_TOLD for s in states if s.at > begun) * dt,
        bool(event["rejoined"]) or _follows_b(record, event),
        int(event["answers"]),
    )


_TOLERATED = 20.0  # times slower: the solver's chi is then still fresh


def split(case: str) -> tuple[str, str, str]:
    """Return fault, what and phase of a case's name."""
    fault, _, rest = case.partition(" ")
    what, _, phase = rest.rpartition(" ")
    return fault, what, phase


def peak_acceleration(states: Sequence[State], limit: Vector, dt: float) -> float:
    """Return the largest change of the command in force over its limit, from tick to tick."""
    return max(
        (
            float((np.abs(b.command - a.command) / (dt * limit)).max())
            for a, b in pairwise(states)
            if a.sender == b.sender and b.tick == a.tick + 1
        ),
        default=0.0,
    )


def out_of_order(entries: Sequence[State] | Sequence[Solved], anew: Sequence[int] = ()) -> int:
    """Return how many messages of a sender do not have a tick above the one before.

    A plant that stands still repeats its state: that is no other order. At the times ``anew``
    [ns] the ticks begin again.
    """
    last: dict[str, int] = {}
    stood: dict[str, bool] = {}  # whether the plant stood still when it was heard last
    count, coming = 0, list(anew)
    for entry in entries:
        if coming and entry.at > coming[0] and entry.tick < max(last.values(), default=0):
            del coming[0]
            last.clear()
        stands = isinstance(entry, State) and entry.status == PlantStatus.PAUSED
        repeated = stands or stood.get(entry.sender, False)
        stood[entry.sender] = stands
        before = last.get(entry.sender, -1)
        count += entry.tick < before or (entry.tick == before and not repeated)
        last[entry.sender] = max(before, entry.tick)
    return count


def _beginnings(states: Sequence[State]) -> list[int]:
    """Return the times [ns] at which another plant took the place of the one before."""
    return [b.at for a, b in pairwise(states) if a.sender != b.sender]


def first_statement(
    told: Iterable[Statement], window: tuple[int, int], pattern: str
) -> Statement | None:
    """Return the first text in a time window [ns] that matches and was not there before it."""
    if not pattern:
        return None
    before = ""
    for entry in sorted(told, key=lambda entry: entry.at):
        if entry.at > window[1]:
            break
        if entry.at < window[0]:
            before = entry.text or before
        elif entry.text and entry.text != before and re.search(pattern, entry.text):
            return entry
    return None


def _follows_b(record: Record, event: dict[str, Any]) -> bool:
    """Return whether the solver was followed after the end of a fault, in a run by the scenario."""
    after = (told for told in record.transitions if event["healed"] < told.at < event["ended"])
    return event["case"].startswith("cut") and any(told.who == "robot_b" for told in after)


def _served(event: dict[str, Any], what: str, record: Record) -> int | None:
    """Return when a process first served after the fault [ns], None where that cannot be seen."""
    healed = event["healed"]
    times: Iterable[int]
    if what == "stack_solver":
        times = (chi.at for chi in record.solutions)
    elif what == "htmpc":
        times = record.plans
    elif what == "recorder" or event["case"].startswith("disk"):
        times = (at for at, bag in record.messages if bag == event["later"])
    else:
        times = _commanded(record)
    return min((at for at in times if at > healed), default=None)


def _commanded(record: Record) -> Iterable[int]:
    """Yield the times at which the plant followed a command."""
    return (
        state.at
        for state in record.states
        if state.status == PlantStatus.FOLLOWING and state.tick > 0
    )


def _seconds(since: int, at: int | None) -> float | None:
    """Return a time difference in seconds."""
    return None if at is None else _NS * (at - since)
