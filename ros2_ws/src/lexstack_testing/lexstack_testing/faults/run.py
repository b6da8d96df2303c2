"""``python -m lexstack_testing.faults.run``: does faults to a running system, and says when.

All cases of one command share a run. What came of them is in its bags; ``events.json`` says what
was done when, by the clock that the recorder uses too.
"""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from lexstack.errors import LexstackError
from lexstack_bringup.processes import RECORDER
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.yaml_text import read_text
from lexstack_testing.faults.cases import CASES, FLOOD, FLOOD_TIME, STOPPED, Case
from lexstack_testing.faults.disk import small_disk
from lexstack_testing.faults.hostile import Stranger
from lexstack_testing.faults.rig import Rig, running

_SEE = 4.0  # s of wall time for the others to notice: diagnostics come once a second
_BLEND = 6.0  # s, long enough for what happens within
_QUICK = 0.4  # s of the switches between cases
_FLOOD_BLEND = 0.2  # s
_DETOUR = ("reach_base", "posture")
_HOME = "track"
_SLOW = "lexstack_testing.faults.slow_solver"


@dataclass(slots=True)
class Event:
    """What was done, when [ns since 1970]; 0: it was not."""

    case: str
    begun: int = 0  # the fault
    healed: int = 0  # the process was started or went on; the network, the disk was there again
    ended: int = 0  # the system has shown that it serves
    bag: str = ""  # the bag at the fault
    later: str = ""  # the bag at the end
    answers: int = 0  # to a flood
    sent: int = 0  # wrong messages
    rejoined: bool = False  # the solver served a switch after it


class Trials:
    """Cases, one after another, on one rig."""

    def __init__(self, rig: Rig, out: Path) -> None:
        """Do them to ``rig``; ``out`` is its folder."""
        self._rig = rig
        self._out = out
        self._count = 0
        self._x = 0.8
        self._stranger: Stranger | None = None

    def perform(self, case: Case) -> Event:
        """Do one case; raises InVainError where the system does not come back."""
        self.calm()
        self._enter(case)
        event = Event(case.name, bag=str(self._rig.run.bags[-1]))
        getattr(self, f"_{case.fault}")(case, event)
        event.rejoined = self._probe(case)
        event.ended, event.later = time.time_ns(), str(self._rig.run.bags[-1])
        return event

    def calm(self) -> None:
        """Go back to the first stack, all robots, under the controller."""
        rig = self._rig
        rig.release()
        rig.until(lambda: rig.commanded, "the plant to follow the controller")
        while not rig.is_on(_HOME):
            rig.switch(_HOME, _QUICK)
            rig.wait(lambda: rig.is_on(_HOME), 3.0)

    def _enter(self, case: Case) -> None:
        """Come to the phase in which the fault shall be."""
        rig = self._rig
        self._count += 1
        stack = _DETOUR[self._count % 2]
        if case.phase == "blending":
            rig.switch(stack, _BLEND)
            rig.until(lambda: any(0.02 < t.alpha < 0.9 for t in rig.all_transitions), "a blend")
        elif case.phase == "following":
            rig.switch(stack, _QUICK)
            rig.until(lambda: rig.is_on(stack) and rig.follows("robot_b"), "to follow the solver")
        elif case.phase == "sequence":
            rig.drive(self._x)
            self._x = 0.8 - self._x
            rig.spin(0.5)

    def _probe(self, case: Case) -> bool:
        """Return whether the solver serves a switch now; asks a few times, and so for the HTMPC."""
        rig = self._rig
        rig.forget()
        rig.release()
        rig.until(lambda: rig.commanded, "the plant to follow the controller")
        if case.what == "htmpc":
            rig.drive(self._x)
            self._x = 0.8 - self._x
        for stack in ("posture", _HOME, "posture", _HOME):
            rig.switch(stack, _QUICK)
            if rig.wait(lambda: rig.follows("robot_b"), 1.5):
                return True
        return False

    # ---- the faults

    def _kill(self, case: Case, event: Event) -> None:
        """Kill a process, let the others see it, start it again."""
        event.begun = self._rig.run.send(case.what, signal.SIGKILL)
        self._rig.spin(_SEE)
        event.healed = self._rig.run.start(case.what)

    def _stop(self, case: Case, event: Event) -> None:
        """Stop a process for a while."""
        event.begun = self._rig.run.send(case.what, signal.SIGSTOP)
        self._rig.spin(STOPPED)
        event.healed = self._rig.run.send(case.what, signal.SIGCONT)

    def _slow(self, case: Case, event: Event) -> None:
        """Put a slow solver in the place of the fast one, for one whole transition."""
        rig = self._rig
        self._replace(f"{_SLOW}:{case.what.split()[0]}")
        self.calm()
        event.begun = time.time_ns()
        rig.switch(_DETOUR[0], 2.0)
        rig.wait(lambda: rig.is_on(_DETOUR[0]), 6.0)
        self._replace("")
        event.healed = time.time_ns()

    def _replace(self, module: str) -> None:
        """End the solver in order, and start the other one."""
        self._rig.run.send("stack_solver", signal.SIGINT)
        self._rig.run.start("stack_solver", module)

    def _flood(self, _case: Case, event: Event) -> None:
        """Ask for switches faster than any can be done; every request is answered."""
        rig, stacks = self._rig, ("reach_base", "posture", _HOME)
        begun, futures = time.monotonic(), []
        event.begun = time.time_ns()
        for number in range(FLOOD):
            due = begun + FLOOD_TIME * number / FLOOD
            rig.wait(lambda due=due: time.monotonic() >= due, FLOOD_TIME)  # type: ignore[misc]
            futures.append(rig.switch_async(stacks[number % len(stacks)], _FLOOD_BLEND))
        event.healed = time.time_ns()
        rig.wait(lambda: all(future.done() for future in futures), 10.0)
        event.answers = sum(future.done() for future in futures)

    def _disk(self, _case: Case, event: Event) -> None:
        """Record to a disk that is full soon; then begin a new bag on a good one."""
        rig = self._rig
        rig.run.send(RECORDER, signal.SIGINT)
        with small_disk(self._out / "small") as (folder, limit):
            rig.run.bags.append(folder / "bag")
            rig.run.start(RECORDER, limit, output=str(rig.run.bags[-1]))
            event.begun, event.bag = time.time_ns(), str(self._out / "small_copy")
            # Not any complaint: a recorder that begins may complain of what it missed.
            rig.wait(lambda: "the bag ends here" in rig.complaints.get(RECORDER, ""), 20.0)
            rig.spin(1.5)
            rig.run.send(RECORDER, signal.SIGINT)
        event.healed = rig.run.start(RECORDER)

    def _message(self, case: Case, event: Event) -> None:
        """Send wrong messages for a while."""
        rig = self._rig
        if self._stranger is None:
            team = [*rig.scenario.robots]
            n = len(rig.state.q) if rig.state is not None else 0
            self._stranger = Stranger(rig.node, team, n)
            rig.spin(1.0)
        before = self._stranger.sent
        event.begun = time.time_ns()
        for _ in range(10):
            self._stranger.send(case.what)
            rig.spin(0.15)
        event.healed, event.sent = time.time_ns(), self._stranger.sent - before


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns 0, or 1 where the system did not come back."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenario", type=Path, required=True, help="resolved")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cases", required=True, help="names, comma-separated")
    options = parser.parse_args(arguments)
    resolved = ResolvedScenario.from_yaml(read_text(options.scenario), str(options.scenario))
    cases = [CASES[name] for name in options.cases.split(",")]
    options.out.mkdir(parents=True, exist_ok=True)
    try:
        events = perform(resolved, options.out, cases)
    except LexstackError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    (options.out / "events.json").write_text(json.dumps(events, indent=1), encoding="utf-8")
    return 0


def perform(resolved: ResolvedScenario, out: Path, cases: Sequence[Case]) -> dict[str, Any]:
    """Do all cases in one run; returns the events, and what was heard meanwhile."""
    following = any(case.phase == "following" for case in cases)
    transition = replace(resolved.scenario.transition, at_end="stay" if following else "adopt")
    resolved = replace(resolved, scenario=replace(resolved.scenario, transition=transition))
    events = []
    with running(resolved, out) as rig:
        trials = Trials(rig, out)
        for case in cases:
            begun = time.monotonic()
            events.append(asdict(trials.perform(case)))
            print(f"{case.name}: {time.monotonic() - begun:.1f} s", file=sys.stderr, flush=True)
        return {"events": events, "heard": rig.heard, "reasons": rig.reasons}


if __name__ == "__main__":
    sys.exit(main())
