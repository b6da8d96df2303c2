"""Tests in real time need the machine to themselves: whether they have it, and trying again.

A test that fails says nothing of lexstack where other programs took the processors meanwhile. So
whoever runs in real time waits until the machine is quiet, for a while, and a failure counts only
if it was quiet before, meanwhile and after. Else the test is tried again, and in the end skipped,
with what was measured: it neither fails for its neighbours, nor passes without having looked.

What others take is what all cores did less what this process and all that it started did. The
latter are known by a variable in their environment, which they inherit also where their parent has
died. In a container the first part is that of the whole machine, so neighbours are seen there, too.
"""

from __future__ import annotations

import functools
import math
import os
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import pytest

from lexstack_testing.system_load import machine_times

T = TypeVar("T")

MARK = "LEXSTACK_TESTS"
"""The variable that all processes of these tests inherit."""

ATTEMPTS = 3
TIMEOUT = 600.0  # s, of a test with all its attempts
_SHARE = 0.15  # of all cores that others may take on a quiet machine: 0.3 of two
_SAMPLE = 0.4  # s, 40 ticks of the kernel's counters on each core
_PATIENCE = 180.0  # s of waiting in a whole session: a machine that is always busy costs it once
_FRESH = 10.0  # s for which a look at a quiet machine holds
_TICKS = os.sysconf("SC_CLK_TCK")


class NoisyMachineWarning(UserWarning):
    """The machine was busy with something else while a test needed it."""


def own_time(processes: Path = Path("/proc")) -> float:
    """Return the processor time of this process and of all that it started [s] (Linux)."""
    mine = os.times()
    total = mine.user + mine.system + mine.children_user + mine.children_system
    mark = f"{MARK}={os.getpid()}".encode()
    for folder in processes.glob("[0-9]*"):
        try:
            if folder.name == str(os.getpid()) or mark not in (
                (folder / "environ").read_bytes().split(b"\0")
            ):
                continue
            words = (folder / "stat").read_text(encoding="ascii", errors="replace")
        except OSError:
            continue  # it has ended, or is another account's
        # Behind the name, which may have blanks: user, system, and both of the children waited for.
        total += sum(int(word) for word in words.rpartition(")")[2].split()[11:15]) / _TICKS
    return total


Moment = tuple[float, float, float]
"""When it was, what all cores had worked, and what we had [s]."""


def cores_of_others(since: Moment | None = None) -> float:
    """Return how many cores others took, since a moment (see ``now``) or while this looks."""
    if since is None:
        since = now()
        time.sleep(_SAMPLE)
    at, machine, own = (new - old for new, old in zip(now(), since, strict=True))
    return max(0.0, machine - own) / at


def now() -> Moment:
    """Return the time, what all cores worked or the host kept for itself, and what we did [s]."""
    return time.monotonic(), sum(machine_times()), own_time()


@dataclass
class Machine:
    """The machine, as the tests of a session see it; tests of this file give it other eyes.

    Attributes:
        look: returns how many cores others take at present, or have taken since a moment.
        now: returns a moment.
        patience: how long may still be waited for a quiet machine in this session [s].
        limit: cores that others may take.
        clock: monotonic [s].
        quiet: when the machine was last seen to be quiet: that holds for a while.
    """

    look: Callable[..., float] = cores_of_others
    now: Callable[[], Moment] = now
    patience: float = _PATIENCE
    limit: float = _SHARE * (os.cpu_count() or 1)
    clock: Callable[[], float] = time.monotonic
    quiet: float = -math.inf

    def settle(self) -> float:
        """Wait until the machine is quiet, or patience is over; return what others take [cores]."""
        begun = self.clock()
        if begun - self.quiet < _FRESH:
            return 0.0  # a look takes longer than many a test
        others = self.look()
        while others > self.limit and self.clock() - begun < self.patience:
            others = self.look()
        if others <= self.limit:
            self.quiet = self.clock()
        self.patience = max(0.0, self.patience - (self.clock() - begun))
        return others

    def undisturbed(self, attempt: Callable[[int], T], name: str) -> T:
        """Return what an attempt returns; try again where it fails on a machine that is not quiet.

        Args:
            attempt: takes its number, from 0 on; fails by an exception.
            name: of what is tried, for those who read why it took long.
        """
        told = []
        for number in range(ATTEMPTS):
            before, begun = self.settle(), self.now()
            try:
                return attempt(number)
            except (Exception, pytest.fail.Exception) as error:
                during, after = self.look(begun), self.look()
                self.quiet = -math.inf  # look again before the next one
                # What was taken meanwhile is not exact where our own processes have died unseen:
                # it is a reason to try again, but not one to know nothing.
                ours = during <= 2.0 * self.limit or number == ATTEMPTS - 1
                if max(before, after) <= self.limit and ours:
                    raise  # the machine was ours: the failure is
                told.append(
                    f"attempt {number + 1}: others took {before:.1f} cores before it, {during:.1f} "
                    f"meanwhile, {after:.1f} after it, and it failed with {type(error).__name__}"
                )
                warnings.warn(f"{name}: {told[-1]}", NoisyMachineWarning, stacklevel=2)
        pytest.skip(f"the machine was never quiet, so nothing is known: {'; '.join(told)}")


MACHINE = Machine()
"""The one of this session."""


def in_real_time(function: Callable[..., Any], machine: Machine | None = None) -> Any:
    """Return a test that is tried again; each attempt has a ``tmp_path`` of its own."""

    @functools.wraps(function)
    def tried(*given: Any, **values: Any) -> None:
        def attempt(number: int) -> None:
            if number and "tmp_path" in values:
                folder = values["tmp_path"] / f"again_{number}"
                folder.mkdir()
                function(*given, **values | {"tmp_path": folder})
            else:
                function(*given, **values)

        (machine or MACHINE).undisturbed(attempt, function.__name__)

    return tried
