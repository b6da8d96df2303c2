"""The whole system over DDS: rate in lockstep, late ticks in realtime, latency, CPU, memory.

Five processes: bridge, the controller, the solver, HTMPC, recorder; a user beside them asks for
what they do. Each case is a run of its own, in phases: the controller alone, the controller
following the solver, the controller following the HTMPC.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from lexstack.errors import LexstackError
from lexstack_bag.run.run import Integers
from lexstack_bag.storage.container import Container, find_files
from lexstack_bag.storage.decoder import Decoder
from lexstack_bag.topics import COMMAND, PLANT_STATE
from lexstack_config.resolved import load_scenario
from lexstack_experiments.benches.clones import Clone
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.measuring import p50_p99
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table

NAME = "system"
SECONDS, SOAK = 60.0, 1800.0
_MODULE = "lexstack_testing.system_load"
_SHORT = 12.0  # s of each phase in lockstep
_PATIENCE = 240.0  # s of wall time beside the phases
_TURNS = 3  # of each clone
_NS = 1_000_000_000
_LITTLE = 0.01  # of a core
_RATE, _LATE = 200.0, 1.0  # Hz, %
_REALTIME = 100.0  # Hz
_WHOM = {
    "alone": "the controller alone",
    "robot_b": "the controller follows the solver",
    "htmpc": "the controller follows the HTMPC",
}


@dataclass(frozen=True, slots=True)
class Case:
    """One run."""

    name: str
    mode: str = "lockstep"
    robots: int = 0  # of eight_robots; 0: the two of faults, with the HTMPC
    solvers: int = 1

    @property
    def phases(self) -> tuple[str, ...]:
        """The phases of the run."""
        return tuple(_WHOM) if not self.robots else tuple(_WHOM)[:2]


CASES = (
    Case("lockstep"),
    Case("realtime", "realtime"),
    Case("2 robots", robots=2),
    Case("4 robots", robots=4),
    Case("8 robots", robots=8),
    Case("8 robots, 2 solvers", robots=8, solvers=2),
)


def run(options: Options) -> Results:
    """Run the first cases."""
    if options.against is not None:
        return _in_turns(options, options.against)
    found: dict[str, list[dict[str, Any]]] = {}
    for case in CASES[: options.cases]:
        found[case.name] = _measured(options, case)
        for phase in found[case.name]:
            options.say(f"{case.name}, {_WHOM[phase['phase']]}: {_rate(phase):.0f} ticks/s")
    rows = [(case, phase) for case in CASES if case.name in found for phase in found[case.name]]
    return options.results(
        NAME,
        _figures(found),
        Table.of(_row(case.name, phase) for case, phase in rows),
        {"rate_hz": 100.0, "seconds_realtime": options.seconds, "seconds_lockstep": _SHORT},
        (
            "The host of a virtual machine left a second alone if it kept less than 1 % of a core.",
            "State to command: from a state's sending to its command's arrival at the recorder.",
            "The user of the run, who asks and otherwise sleeps, shares the cores; so may others.",
        ),
    )


def _in_turns(options: Options, folder: Path) -> Results:
    """Run this clone and another one in turns, in lockstep: the ratio is that of the medians."""
    case, theirs = CASES[0], Clone(folder)
    runs: dict[str, list[list[dict[str, Any]]]] = {"this clone": [], folder.name: []}
    for turn in range(1, _TURNS + 1):
        for name, clone in zip(runs, (None, theirs), strict=True):
            runs[name].append(_measured(options, case, clone, f"{turn} of {name}"))
            rates = ", ".join(f"{_rate(phase):.0f}" for phase in runs[name][-1])
            options.say(f"turn {turn}, {name}: {rates} ticks/s")
    figures = []
    for k, phase in enumerate(case.phases):
        ours, others = (np.median([_rate(run[k]) for run in each]) for each in runs.values())
        name = f"Lockstep over {folder.name}, {_WHOM[phase]}"
        figures.append(Figure(name, float(ours / others), "times"))
    rows = [
        _row(f"{name}, turn {turn}", phase)
        for name, each in runs.items()
        for turn, run in enumerate(each, 1)
        for phase in run
    ]
    setup = {"turns": _TURNS, "seconds_lockstep": _SHORT}
    return options.results(NAME, figures, Table.of(rows), setup)


def _measured(
    options: Options, case: Case, clone: Clone | None = None, name: str = ""
) -> list[dict[str, Any]]:
    """Run one case, in another clone if one is given.

    Raises LexstackError where the run does not come to its end.
    """
    out = options.out / re.sub(r"\W+", "_", name or case.name.replace(",", ""))
    out.mkdir()
    path = out / "asked.yaml"
    path.write_text(_scenario(options, case, out, clone), encoding="utf-8")
    seconds = _SHORT if case.mode == "lockstep" else options.seconds / len(case.phases)
    words = ["--scenario", str(path), "--out", str(out), "--seconds", f"{seconds:g}"]
    words += ["--phases", ",".join(case.phases)]
    timeout = _PATIENCE + len(case.phases) * seconds
    if clone is not None:
        done = clone.python("-m", clone.load, *words, timeout=timeout)
    else:
        done = subprocess.run(
            [sys.executable, "-m", _MODULE, *words],
            check=False,
            capture_output=True,
            text=True,
            timeout=timeout,
        )
    if done.returncode:
        last = done.stderr.strip().splitlines()
        raise LexstackError(f"{case.name}: {last[-1] if last else 'failed'}; logs: {out / 'logs'}")
    phases: list[dict[str, Any]] = json.loads(done.stdout.splitlines()[-1])
    _add_times(out / "bag", phases)
    return phases


def _scenario(options: Options, case: Case, out: Path, clone: Clone | None) -> str:
    """Return the resolved scenario of a case: it has no end and no events."""
    name = "eight_robots" if case.robots else "faults"
    config = options.config if clone is None else clone.root / "config"
    source = config / "scenarios" / f"{name}.yaml"
    data = yaml.safe_load(source.read_text(encoding="utf-8"))
    if case.robots:
        data["robots"] = dict(list(data["robots"].items())[: case.robots])
        data["base_target"] = {name: data["base_target"][name] for name in data["robots"]}
    data |= {"events": [], "mode": case.mode, "duration": 1e5, "seed": options.seed}
    if case.solvers > 1:
        data["solvers"] = case.solvers
    path = out / "scenario.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return clone.resolved(path) if clone is not None else load_scenario(path, config).to_yaml()


def _add_times(bag: Path, phases: Sequence[dict[str, Any]]) -> None:
    """Add to each phase what its bag says of its times.

    ``latency``: median and 99th percentile from state to command [ms], or None. ``best``: ticks in
    the second with the most of them. ``undisturbed``: ticks, and late ones of them, in seconds of
    which the host kept next to nothing.
    """
    sent: dict[int, int] = {}
    late: list[tuple[int, int]] = []
    arrived: dict[int, int] = {}
    decode = Decoder()
    for message in Container(find_files(bag)).messages():
        if message.topic == PLANT_STATE:
            state = decode(message)
            sent.setdefault(state.tick, message.publish_time)
            late.append((message.publish_time, state.late_ticks))
        elif message.topic == COMMAND:
            arrived.setdefault(decode(message).tick, message.log_time)
    for phase in phases:
        first, last = phase["span"]
        delays = [
            1e-6 * (at - sent[tick])
            for tick, at in arrived.items()
            if tick in sent and first <= at <= last
        ]
        phase["latency"] = p50_p99(delays) if delays else None
        seconds = Counter((at - first) // _NS for at in sent.values() if first <= at <= last)
        phase["best"] = max(seconds.values(), default=None)
        phase["undisturbed"] = _undisturbed(np.array(late), phase["kept"])


def _undisturbed(late: Integers, kept: Sequence[tuple[int, float]]) -> tuple[int, int]:
    """Return the ticks, and the late ones of them, of the intervals that the host left alone.

    Args:
        late: shape (T, 2): time [ns] of each tick and the late ones so far.
        kept: time [ns], and what the host has kept until then [s].
    """
    ends = np.searchsorted(late[:, 0], [at for at, _ in kept])
    ticks = beyond = 0
    for (begin, before), (end, after), first, last in zip(
        kept, kept[1:], ends, ends[1:], strict=False
    ):
        if first and after - before <= _LITTLE * (end - begin) / _NS:
            ticks += int(last - first)
            beyond += int(late[last - 1, 1] - late[first - 1, 1])
    return ticks, beyond


def _rate(phase: dict[str, Any]) -> float:
    """Return ticks per second of wall time."""
    return float(phase["ticks"] / phase["seconds"])


def _row(case: str, phase: dict[str, Any]) -> dict[str, Cell]:
    """Return one line of the table."""
    ticks = max(phase["ticks"], 1)
    latency = phase["latency"] or (None, None)
    return {
        "case": case,
        "phase": _WHOM[phase["phase"]],
        "ticks/s": _rate(phase),
        "in its best second": phase["best"],
        "late %": 100.0 * phase["late"] / ticks,
        "missing %": 100.0 * phase["missing"] / ticks,
        "state to command p50 ms": latency[0],
        "p99 ms": latency[1],
        "CPU % of a core: bridge": _share(phase, "sim_bridge"),
        "controller": _share(phase, "hqp_controller"),
        "solver": _share(phase, "stack_solver"),
        "HTMPC": _share(phase, "htmpc"),
        "recorder": _share(phase, "recorder"),
        "others on the machine %": phase["others"],
        "kept by the host %": phase["stolen"],
    }


def _share(phase: dict[str, Any], node: str) -> float | None:
    """Return the CPU share of a node's processes [%], None where it has none."""
    shares = [share for name, share in phase["cpu"].items() if name.rstrip("_0123456789") == node]
    return sum(shares) if shares else None


def _figures(found: dict[str, list[dict[str, Any]]]) -> list[Figure]:
    """Return what has a goal, and what is stated."""
    figures = []
    for phase in found.get("lockstep", ()):
        name = f"Lockstep, five processes, {_WHOM[phase['phase']]}"
        figures.append(Figure(name, _rate(phase), "ticks/s", Goal(">=", _RATE)))
        figures.append(Figure(f"{name}, best second", phase["best"], "ticks/s"))
    realtime = found.get("realtime")
    if realtime:
        ticks = sum(phase["ticks"] for phase in realtime)
        late = 100.0 * sum(phase["late"] for phase in realtime) / ticks
        figures.append(Figure("Realtime at 100 Hz: late ticks", late, "%", Goal("<=", _LATE)))
        alone = np.sum([phase["undisturbed"] for phase in realtime], axis=0)
        if alone[0]:
            name = "Realtime, late ticks in seconds that the host left alone"
            figures.append(Figure(name, 100.0 * float(alone[1] / alone[0]), "%"))
            figures.append(Figure("Realtime, such seconds", float(alone[0] / _REALTIME), "s"))
        followed = [phase["latency"] for phase in realtime if phase["latency"]]
        figures += [
            Figure(
                f"State to command, {word}, worst phase", max(each[i] for each in followed), "ms"
            )
            for i, word in enumerate(("median", "p99"))
            if followed
        ]
        figures += [
            Figure(f"Memory of {name}: growth", slope, "kB/min")
            for name, slope in _slopes(realtime).items()
        ]
    return figures


def _slopes(phases: Sequence[dict[str, Any]]) -> dict[str, float]:
    """Return how fast each process grows in the run's last quarter [kB/min], by least squares."""
    slopes = {}
    for name in phases[0]["memory"]:
        sizes = [size for phase in phases for size in phase["memory"].get(name, ())]
        last = sizes[3 * len(sizes) // 4 :]  # a process has met all its work by then
        if len(last) > 2:
            slopes[name] = 60.0 * float(np.polyfit(np.arange(len(last)), last, 1)[0])
    return slopes


EXPERIMENT = Experiment(
    "five processes over DDS: rate, late ticks, latency, CPU, memory; 2, 4, 8 robots",
    "runs",
    len(CASES),
    run,
    seconds=SECONDS,
    soak=SOAK,
    against=True,
)
