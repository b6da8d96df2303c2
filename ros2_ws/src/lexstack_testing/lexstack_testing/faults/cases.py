"""The faults: what is done to which process, in which phase; values, nothing is run here."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

Phase = Literal["idle", "blending", "following", "sequence"]
Fault = Literal["kill", "stop", "slow", "flood", "disk", "message"]

PHASES: tuple[Phase, ...] = ("idle", "blending", "following", "sequence")
PROCESSES = ("stack_solver", "hqp_controller", "htmpc", "sim_bridge", "recorder")
STOPPED = 4.5  # s of wall time that a process stands still: diagnostics need up to 3.5 s to see it
SLOWER = (10.0, 200.0)  # times that the solver takes
FLOOD, FLOOD_TIME = 1000, 10.0  # requests, s
MESSAGES = (
    "unknown stacks",
    "NaN and inf",
    "wrong length",
    "stale",
    "replayed",
    "of the future",
    "another sender",
    "garbage bytes",
)


@dataclass(frozen=True, slots=True)
class Case:
    """One fault.

    Attributes:
        fault: what is done.
        phase: in which phase of the controller.
        what: which process, or how much or which messages.
    """

    fault: Fault
    phase: Phase
    what: str

    @property
    def name(self) -> str:
        """What it is called in tables and on the command line; no commas."""
        return f"{self.fault} {self.what} {self.phase}"


def all_cases() -> Iterator[Case]:
    """Yield every case, what matters most first; 'following' needs a run of its own."""
    for fault in ("kill", "stop"):
        for process in PROCESSES:
            for phase in PHASES:
                yield Case(fault, phase, process)
    for factor in SLOWER:
        yield Case("slow", "blending", f"{factor:g} times")
    yield Case("flood", "idle", f"{FLOOD} requests")
    yield Case("disk", "blending", "full")
    for kind in MESSAGES:
        yield Case("message", "blending", kind)


CASES = {case.name: case for case in all_cases()}
