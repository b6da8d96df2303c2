"""Steps of the set-up: each shows its progress and writes to one log."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from workspace.errors import SetupError

TAIL_LINES = 12


class Steps:
    """Runs the steps of a set-up.

    Args:
        total: Number of steps.
        log: File that takes all output of the commands.
        variables: Environment of the commands.
    """

    def __init__(self, total: int, log: Path, variables: Mapping[str, str]) -> None:
        """Begin before the first step."""
        self._total = total
        self._log = log
        self._variables = dict(variables)
        self._number = 0
        self._name = ""
        self._start = 0.0

    @contextmanager
    def step(self, name: str, advice: str = "") -> Iterator[None]:
        """Show a step while it runs; `advice` says what to do when it fails."""
        self._number += 1
        self._name = name
        self._start = time.monotonic()
        self._show(running=True)
        try:
            yield
        except (subprocess.CalledProcessError, OSError) as error:
            self._show_tail()
            advice = f"{advice}; " if advice else ""
            raise SetupError(
                f"step '{name}' failed ({_reason(error)}): {advice}"
                "see build/setup.log, then run ./scripts/setup again"
            ) from error
        self._show(running=False)

    def run(self, *command: str | Path, cwd: Path | None = None) -> None:
        """Run a command of the current step.

        Raises:
            subprocess.CalledProcessError: It failed.
        """
        with self._log.open("a") as log:
            print("$", *command, file=log, flush=True)
            process = subprocess.Popen(
                [str(word) for word in command],
                cwd=cwd,
                env=self._variables,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                close_fds=False,  # children share the lock on the set-up while they live
                start_new_session=True,
            )
            try:
                self._wait(process)
            finally:
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        if process.returncode:
            raise subprocess.CalledProcessError(process.returncode, [str(c) for c in command])

    def _wait(self, process: subprocess.Popen[bytes]) -> None:
        """Wait for the process and keep the progress line alive."""
        while True:
            try:
                process.wait(timeout=1.0)
                return
            except subprocess.TimeoutExpired:
                self._show(running=True)

    def _show(self, *, running: bool) -> None:
        """Write the progress line; over itself on a terminal, else only at the end."""
        line = (
            f"[{self._number}/{self._total}] {self._name}: {time.monotonic() - self._start:.0f} s"
        )
        if sys.stderr.isatty():
            print(f"\r{line}", end="" if running else "\n", file=sys.stderr, flush=True)
        elif not running:
            print(line, file=sys.stderr, flush=True)

    def _show_tail(self) -> None:
        """Show the end of the log."""
        lines = self._log.read_text(errors="replace").splitlines() if self._log.exists() else []
        print("", *lines[-TAIL_LINES:], sep="\n  ", file=sys.stderr)


def _reason(error: Exception) -> str:
    """Return in few words why a step failed."""
    if isinstance(error, subprocess.CalledProcessError):
        return f"exit code {error.returncode}"
    return str(error)
