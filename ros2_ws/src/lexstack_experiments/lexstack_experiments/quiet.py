"""Whether the machine was left to a bench: what others took, and what that did to a fixed loop.

Ratios between solvers that take turns hold on a busy machine, absolute times do not. What is looked
at is the machine's own account (Linux): the load before, processor time that other programs had or
that the host of a virtual machine kept for itself, how often this thread lost its core against its
will, and how evenly a loop of fixed length ran before and after. Elsewhere only the loop is known.
"""

from __future__ import annotations

import os
import resource
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic, thread_time

import numpy as np

LOAD = 0.5  # runnable programs per core, in the minute before
OTHERS = 0.15  # of all cores
STEAL = 0.01  # of all cores
SWITCHES = 50.0  # per second of processor time
SPREAD = 1.15  # p90 over p10 of the loop
DRIFT = 1.1  # the loop's median after over before, or the other way round
_LOOPS, _LENGTH = 40, 20_000
_TICK = float(os.sysconf("SC_CLK_TCK"))
_STEAL = 7  # place in the kernel's line of processor times
_IDLE = slice(3, 5)  # idle and waiting for disks


@dataclass(frozen=True, slots=True)
class Quiet:
    """How quiet the machine was during a bench.

    Attributes:
        load: mean number of runnable programs in the minute before it.
        others: cores that other programs had meanwhile.
        steal: cores that the host kept for itself meanwhile.
        switches: how often the process lost a core, per second of its processor time.
        spread: p90 over p10 of the loop's processor time.
        drift: median of the loop after the bench, over that before it.
        reasons: why the machine was not quiet, in words; empty: it was.
    """

    load: float
    others: float
    steal: float
    switches: float
    spread: float
    drift: float
    reasons: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """Say it in one line."""
        if not self.reasons:
            return "The machine was quiet."
        return f"The machine was not quiet: {'; '.join(self.reasons)}. Ratios hold, times do not."


@dataclass(frozen=True, slots=True)
class Counters:
    """What was counted up to a moment [s].

    Attributes:
        clock: of the wall.
        busy: processor time of the whole machine, with what the host kept.
        steal: processor time that the host kept.
        own: processor time of this process and of the children that it waited for.
        switches: involuntary ones of this process.
    """

    clock: float
    busy: float
    steal: float
    own: float
    switches: int

    @classmethod
    def now(cls, stat: Path = Path("/proc/stat")) -> Counters:
        """Return the present ones; those of the machine are zero where they are not told."""
        busy, steal = machine_times(stat.read_text()) if stat.is_file() else (0.0, 0.0)
        mine, children = (resource.getrusage(who) for who in _WHO)
        own = sum(usage.ru_utime + usage.ru_stime for usage in (mine, children))
        return cls(monotonic(), busy, steal, own, mine.ru_nivcsw)


_WHO = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)


class Watch:
    """Looks at the machine from its making until ``seen``."""

    def __init__(self) -> None:
        """Take the load, the loop, and the counters behind it."""
        self._load = os.getloadavg()[0]
        self._loop = loop_times()
        self._begun = Counters.now()

    def seen(self) -> Quiet:
        """Return how quiet it was since."""
        ended = Counters.now()
        return judged(self._load, (self._begun, ended), (self._loop, loop_times()), cores())


def cores() -> int:
    """Return how many cores the machine has."""
    return os.cpu_count() or 1


def machine_times(stat: str) -> tuple[float, float]:
    """Return busy time and the host's share of it [s], of all cores, from ``/proc/stat``."""
    words = next(line for line in stat.splitlines() if line.startswith("cpu ")).split()[1:9]
    times = np.array([float(word) for word in words]) / _TICK
    steal = float(times[_STEAL]) if times.size > _STEAL else 0.0
    return float(times.sum() - times[_IDLE].sum()), steal


def loop_times(count: int = _LOOPS) -> np.ndarray:
    """Return the thread's processor time of a loop of fixed length, several times, (count,) [s]."""
    times = np.empty(count)
    for k in range(count):
        begun = thread_time()
        sum(range(_LENGTH))
        times[k] = thread_time() - begun
    return times


def judged(
    load: float, counters: tuple[Counters, Counters], loops: tuple[np.ndarray, np.ndarray], n: int
) -> Quiet:
    """Return how quiet it was.

    Args:
        load: in the minute before.
        counters: before and after.
        loops: times of the loop before and after [s].
        n: cores of the machine.
    """
    first, last = counters
    wall, own = max(last.clock - first.clock, 1e-9), max(last.own - first.own, 1e-9)
    steal = max(last.steal - first.steal, 0.0) / wall
    others = max(last.busy - first.busy - (last.own - first.own), 0.0) / wall - steal
    switches = (last.switches - first.switches) / own
    before, after = (float(np.median(times)) for times in loops)
    low, high = np.percentile(np.concatenate(loops), (10.0, 90.0))
    found = Quiet(load, max(others, 0.0), steal, switches, float(high / low), after / before)
    return replace(found, reasons=_reasons(found, n))


def _reasons(seen: Quiet, n: int) -> tuple[str, ...]:
    """Return what was too much on a machine of n cores, in words."""
    apart = max(seen.drift, 1.0 / seen.drift)
    found = (
        (seen.load > LOAD * n, f"load {seen.load:.1f} on {n} cores before it"),
        (seen.others > OTHERS * n, f"others had {seen.others:.2f} cores"),
        (seen.steal > STEAL * n, f"the host kept {seen.steal:.2f} cores"),
        (seen.switches > SWITCHES, f"{seen.switches:.0f} involuntary switches per second"),
        (seen.spread > SPREAD, f"a fixed loop varied by {seen.spread:.2f} (p90 over p10)"),
        (apart > DRIFT, f"it took {seen.drift:.2f} times as long after as before"),
    )
    return tuple(text for much, text in found if much)
