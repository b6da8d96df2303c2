"""Commands and nodes run by their ``main`` in this process: most of a short process is imports."""

from __future__ import annotations

import importlib
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest


@dataclass(frozen=True)
class Done:
    """What a command did: its exit code, and what it printed."""

    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def run_command(capfd, monkeypatch) -> Iterator[Callable[..., Done]]:
    """Return a function that runs ``python -m MODULE ARGUMENTS`` here; signals are given back."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def run(module: str, *arguments: Any) -> Done:
        given = [str(argument) for argument in arguments]
        monkeypatch.setattr("sys.argv", [module, *given])
        capfd.readouterr()
        try:
            code = importlib.import_module(module).main()
        except SystemExit as end:  # argparse
            code = end.code
        return Done(int(code), *capfd.readouterr())

    yield run
    for number, handler in before.items():
        signal.signal(number, handler)
