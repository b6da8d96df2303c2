"""A load for ``./scripts/bench system``: a whole system at work, and what it costs.

``python -m lexstack_testing.system_load --scenario FILE --out DIR --seconds 20`` prints JSON: for
each phase ticks, time, late ticks, and the CPU time and memory of every process.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from lexstack.errors import LexstackError
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.yaml_text import read_text
from lexstack_interfaces.msg import PlantState
from lexstack_testing.faults.rig import Rig, running

PHASES = ("alone", "robot_b", "htmpc")
_LONGEST = 60.0  # s, of a transition
_FAR = 60.0  # m, farther than the base gets
_RENEW = 5.0  # s of wall time between two looks whether all are still at work
_SETTLE = 1.0  # s of wall time before a phase counts
_SAMPLE = 1.0  # s of wall time between two looks at the memory
_TICKS = os.sysconf("SC_CLK_TCK")
_PAGE = os.sysconf("SC_PAGE_SIZE") / 1024.0


@dataclass(slots=True)
class Measured:
    """One phase of the load.

    Attributes:
        phase: whom the controller follows.
        ticks: of the plant; seconds: of wall time for them.
        late: ticks that began late; missing: ticks without a command.
        cpu: share of a core by process [%].
        others: share of a core that all else on the machine took [%].
        stolen: share of a core that a virtual machine's host kept for itself [%].
        kept: what it had kept so far [s], every second, each with its time [ns since 1970].
        memory: resident size by process [kB], every second.
        span: begin and end [ns since 1970].
    """

    phase: str
    ticks: int = 0
    seconds: float = 0.0
    late: int = 0
    missing: int = 0
    cpu: dict[str, float] = field(default_factory=dict)
    others: float = 0.0
    stolen: float = 0.0
    kept: list[tuple[int, float]] = field(default_factory=list)
    memory: dict[str, list[int]] = field(default_factory=dict)
    span: tuple[int, int] = (0, 0)


def measured(rig: Rig, phase: str, seconds: float) -> Measured:
    """Return what a phase costs; this process sleeps meanwhile."""
    _enter(rig, phase)
    pids = {child.name: child.process.pid for child in rig.run.supervisor.children}
    result = Measured(phase, memory={name: [] for name in pids})
    rig.spin(_SETTLE)
    before, begun, first = _now(rig), time.monotonic(), time.time_ns()
    renewed = begun
    spent = {name: cpu_time(pid) for name, pid in pids.items()}
    own, (all_, stolen) = time.process_time(), machine_times()
    result.kept.append((time.time_ns(), stolen))
    while time.monotonic() - begun < seconds:
        time.sleep(max(0.0, min(_SAMPLE, begun + seconds - time.monotonic())))
        for name, pid in pids.items():
            result.memory[name].append(resident(pid))
        result.kept.append((time.time_ns(), machine_times()[1]))
        if time.monotonic() - renewed > _RENEW:
            _renew(rig, phase)
            renewed = time.monotonic()
    after, result.seconds = _now(rig), time.monotonic() - begun
    result.cpu = {
        name: 100.0 * (cpu_time(pid) - spent[name]) / result.seconds for name, pid in pids.items()
    }
    ours = 100.0 * (time.process_time() - own) / result.seconds + sum(result.cpu.values())
    all_, stolen = (end - begin for end, begin in zip(machine_times(), (all_, stolen), strict=True))
    result.others = 100.0 * all_ / result.seconds - ours
    result.stolen = 100.0 * stolen / result.seconds
    result.ticks = after.tick - before.tick
    result.late = after.late_ticks - before.late_ticks
    result.missing = after.missing_ticks - before.missing_ticks
    result.span = first, time.time_ns()
    rig.run.supervisor.check()
    return result


def _enter(rig: Rig, phase: str) -> None:
    """Let the controller follow whom the phase names."""
    if phase == "robot_b":
        rig.switch("posture", _LONGEST)
        rig.until(lambda: rig.follows("robot_b"), "to follow the solver")
    elif phase == "htmpc":
        rig.drive(_FAR)
    else:
        while not rig.is_on("track"):
            rig.switch("track", 0.5)
            rig.wait(lambda: rig.is_on("track"), 5.0)


def _renew(rig: Rig, phase: str) -> None:
    """Keep the others at work: ask for another stack, or sequence, where one comes to its end."""
    rig.forget()
    rig.wait(lambda: bool(rig.transitions), 1.0)
    told = rig.all_transitions
    if phase == "htmpc" and not rig.follows("htmpc"):
        rig.drive(_FAR if rig.state is None or rig.state.q[0] < 0.5 * _FAR else 0.0)
    if phase == "robot_b" and told and (not rig.follows("robot_b") or told[0].alpha > 0.5):
        rig.switch("reach_base" if told[0].to_stack == "posture" else "posture", _LONGEST)


def _now(rig: Rig) -> PlantState:
    """Return the state of now."""
    rig.forget()
    rig.until(lambda: rig.state is not None, "a state of the plant")
    assert rig.state is not None
    return rig.state


def cpu_time(pid: int) -> float:
    """Return the processor time that a process has used so far [s] (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS


def machine_times() -> tuple[float, float]:
    """Return how long all cores have worked, and been kept by the host, so far [s] (Linux)."""
    line = Path("/proc/stat").read_text(encoding="ascii").splitlines()[0]
    user, nice, system, _idle, _wait, irq, softirq, steal = (int(w) for w in line.split()[1:9])
    return (user + nice + system + irq + softirq) / _TICKS, steal / _TICKS


def resident(pid: int) -> int:
    """Return the memory of a process that is in use [kB] (Linux)."""
    return round(int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1]) * _PAGE)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns 0, or 1 where the system failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenario", type=Path, required=True, help="resolved")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seconds", type=float, required=True, help="of wall time, each phase")
    parser.add_argument("--phases", default=",".join(PHASES))
    options = parser.parse_args(arguments)
    resolved = ResolvedScenario.from_yaml(read_text(options.scenario), str(options.scenario))
    options.out.mkdir(parents=True, exist_ok=True)
    try:
        with running(resolved, options.out) as rig:
            found = [measured(rig, name, options.seconds) for name in options.phases.split(",")]
    except LexstackError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(json.dumps([asdict(each) for each in found]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
