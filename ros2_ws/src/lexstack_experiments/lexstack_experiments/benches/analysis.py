"""How long the analysis of a long bag takes, and how much memory at most.

The bags are made, not recorded: two robots at 100 Hz, every topic of a demo, the solver never idle.
Each is analysed by ``./scripts/analyze`` in a process of its own, report included; its peak is the
largest resident size that the system saw.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from lexstack.errors import LexstackError
from lexstack_bag.storage.container import find_files
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.results import Figure, Goal, Results, Table
from lexstack_experiments.runs import scenario_of
from lexstack_experiments.synthetic import write_bag

NAME = "analysis"
MINUTES = (1.0, 10.0, 60.0)
_PEAK = 1500.0  # MB, for an hour
_MB = 1e6


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the analysis of one bag took."""

    minutes: float
    messages: int
    size: float  # MB on the disk
    seconds: float  # of wall time
    peak: float  # MB


def run(options: Options) -> Results:
    """Make and analyse every bag."""
    resolved = scenario_of(options.config)
    outcomes = []
    for minutes in MINUTES[: options.cases]:
        folder = options.out / f"{minutes:g}_min"
        begun = time.monotonic()
        counts = write_bag(folder / "bag", resolved, minutes, lambda _part: None)
        options.say(f"wrote {minutes:g} min in {time.monotonic() - begun:.0f} s")
        seconds, peak = analysed(folder)
        size = sum(path.stat().st_size for path in find_files(folder)) / _MB
        outcomes.append(Outcome(minutes, sum(counts.values()), size, seconds, peak))
        options.say(f"analysed {minutes:g} min in {seconds:.0f} s, peak {peak:.0f} MB")
    hour = outcomes[-1] if outcomes[-1].minutes == MINUTES[-1] else None
    columns = ("minutes", "messages", "bag MB", "analysis s", "peak MB", "run time / analysis time")
    rows = (
        (o.minutes, o.messages, o.size, o.seconds, o.peak, 60.0 * o.minutes / o.seconds)
        for o in outcomes
    )
    return options.results(
        NAME,
        (
            Figure("Peak memory, one hour", hour.peak if hour else None, "MB", Goal("<=", _PEAK)),
            Figure("Analysis of one hour", hour.seconds if hour else None, "s"),
        ),
        Table(columns, rows),
        {"rate_hz": resolved.scenario.rate, "robots": len(resolved.scenario.robots)},
        ("Report and pictures included; the peak is that of the whole process.",),
    )


def analysed(folder: Path) -> tuple[float, float]:
    """Return the wall time [s] and peak memory [MB] of ``./scripts/analyze`` (Linux).

    Raises:
        LexstackError: it failed; the text is its last line.
    """
    command = [sys.executable, "-m", "lexstack_bag.commands.analyze", str(folder)]
    begun = time.monotonic()
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise LexstackError(f"analyze failed: {errors.strip().splitlines()[-1]}")
    return time.monotonic() - begun, usage.ru_maxrss * 1024 / _MB


EXPERIMENT = Experiment("analysis of long bags: time and peak memory", "bags", len(MINUTES), run)
