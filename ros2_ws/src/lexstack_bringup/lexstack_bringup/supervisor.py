"""Child processes: started, watched, and ended, whatever happens."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lexstack.errors import LexstackError
from lexstack_ros.node.parent import PARENT

_LAST_LINES = 15


class ChildDiedError(LexstackError):
    """A child process ended by itself; the text says which and shows its last lines."""


class NotReadyError(LexstackError):
    """A child process did not become ready in time."""


@dataclass(frozen=True, slots=True)
class Child:
    """One process and the file that holds all it printed."""

    name: str
    process: subprocess.Popen[bytes]
    log: Path

    def printed(self, word: str) -> bool:
        """Return whether the process has printed a line that is exactly ``word``."""
        return word in self.log.read_text(encoding="utf-8", errors="replace").splitlines()

    def last_lines(self) -> str:
        """Return the end of what it printed."""
        lines = self.log.read_text(encoding="utf-8", errors="replace").splitlines()
        return "\n".join(f"  {self.name}| {line}" for line in lines[-_LAST_LINES:])


class Supervisor:
    """Starts Python modules as processes and ends them in the order they were started."""

    def __init__(self, logs: Path, environment: dict[str, str] | None = None) -> None:
        """Write each child's output to ``logs``; give all of them ``environment``."""
        logs.mkdir(parents=True, exist_ok=True)
        self._logs = logs
        self._environment = {**os.environ, **(environment or {}), PARENT: str(os.getpid())}
        self.children: list[Child] = []

    def start(self, name: str, module: str, arguments: Sequence[str] = ()) -> Child:
        """Start ``python -m module arguments`` and return it."""
        log = self._logs / f"{name}.log"
        with log.open("wb") as file:
            process = subprocess.Popen(
                [sys.executable, "-m", module, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                env=self._environment,
                # A session of its own: Ctrl-C reaches this process alone, which then ends the
                # children in order.
                start_new_session=True,
            )
        child = Child(name, process, log)
        self.children.append(child)
        return child

    def check(self, expected: Sequence[str] = ()) -> None:
        """Raise ChildDiedError if a child has ended, unless its name is ``expected``."""
        for child in self.children:
            code = child.process.poll()
            if code is not None and child.name not in expected:
                raise ChildDiedError(
                    f"{child.name} {_ending(code)}; its last lines:\n{child.last_lines()}"
                )

    def wait_printed(self, names: Sequence[str], word: str, timeout: float) -> None:
        """Wait until each named child printed ``word``; raises NotReadyError, ChildDiedError."""
        end = time.monotonic() + timeout
        waiting = [child for child in self.children if child.name in names]
        while True:
            self.check()
            waiting = [child for child in waiting if not child.printed(word)]
            if not waiting:
                return
            if time.monotonic() > end:
                late = ", ".join(child.name for child in waiting)
                raise NotReadyError(
                    f"{late}: not {word} after {timeout:g} s; last lines:\n"
                    + "\n".join(child.last_lines() for child in waiting)
                )
            time.sleep(0.05)

    def end(self, timeout: float = 10.0) -> list[str]:
        """End all children, first started first; return the names of those that had to be killed.

        Each gets SIGINT, then after ``timeout`` seconds SIGTERM, and SIGKILL at the last.
        """
        stubborn = []
        for child in self.children:
            if not _ended(child.process, signal.SIGINT, timeout) and not _ended(
                child.process, signal.SIGTERM, 0.5 * timeout
            ):
                _ended(child.process, signal.SIGKILL, timeout)
                stubborn.append(child.name)
        return stubborn


def _ended(process: subprocess.Popen[bytes], number: signal.Signals, timeout: float) -> bool:
    """Send a signal, if the process still runs, and return whether it ends in time."""
    if process.poll() is None:
        # A stopped process takes no signal but SIGKILL before it goes on.
        process.send_signal(number)
        process.send_signal(signal.SIGCONT)
    try:
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        return False
    return True


def _ending(code: int) -> str:
    """Return an exit code in words."""
    if code >= 0:
        return f"ended with exit code {code}"
    return f"was killed by {signal.Signals(-code).name}"
