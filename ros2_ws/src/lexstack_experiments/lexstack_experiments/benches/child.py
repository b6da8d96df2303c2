"""A worker in a process of its own: asked and answered by lines of JSON."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from lexstack.errors import LexstackError
from lexstack_experiments import workers

_FOLDER = Path(workers.__file__).parent


class Child:
    """A process that runs one program of ``lexstack_experiments.workers``; a context."""

    def __init__(
        self, program: str, python: Path | str = sys.executable, source: Path | None = None
    ) -> None:
        """Start it.

        Args:
            program: its name, e.g. ``placo``.
            python: that runs it, if its packages are not ours.
            source: root of a clone whose code it is to import in place of ours.
        """
        self.name = program
        environment = dict(os.environ)
        if source is not None:
            environment |= {"PYTHONPATH": path_of(source), "LEXSTACK_ROOT": str(source)}
        elif str(python) != sys.executable:
            environment.pop("PYTHONPATH", None)  # another Python has its own packages
        self._process = subprocess.Popen(
            [str(python), str(_FOLDER / f"{program}.py")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=environment,
        )

    def ask(self, do: str, **arguments: Any) -> Any:
        """Return a handler's answer; raises LexstackError where it fails or the process ends."""
        sent, heard = self._process.stdin, self._process.stdout
        assert sent is not None
        assert heard is not None
        try:
            sent.write(json.dumps({"do": do, **arguments}, default=_listed) + "\n")
            sent.flush()
        except BrokenPipeError:
            pass  # the next line says so
        line = heard.readline()
        if not line:
            code = self._process.wait()
            raise LexstackError(f"worker {self.name}: ended with {code} when asked to {do}")
        found = json.loads(line)
        if "error" in found:
            raise LexstackError(f"worker {self.name}: {do}: {found['error']}")
        return found["answer"]

    def close(self) -> None:
        """End it."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()

    def __enter__(self) -> Child:
        """Return it."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it."""
        self.close()


def path_of(source: Path) -> str:
    """Return the Python path of a clone's own packages, whatever they are called there.

    Raises:
        LexstackError: it has no packages where this project has them.
    """
    folders = sorted(path.parent for path in (source / "ros2_ws" / "src").glob("*/setup.py"))
    if not folders:
        raise LexstackError(f"{source}: no clone of this project: ros2_ws/src has no packages")
    return os.pathsep.join(map(str, (*folders, source / "sim_bridge")))


def in_turns(
    turns: int, measures: Mapping[str, Callable[[], Sequence[float]]]
) -> dict[str, np.ndarray]:
    """Return the times of all who are measured, one row per turn, measured one after the other.

    Who begins changes from turn to turn, so that nobody always comes after the same one.

    Args:
        turns: how many.
        measures: by name; each returns the times of one turn, always as many.
    """
    names, found = list(measures), {name: [] for name in measures}
    for turn in range(turns):
        for name in names if turn % 2 == 0 else reversed(names):
            found[name].append(np.asarray(measures[name](), dtype=float))
    return {name: np.array(rows) for name, rows in found.items()}


def _listed(value: Any) -> Any:
    """Return an array as a list."""
    return np.asarray(value).tolist()
