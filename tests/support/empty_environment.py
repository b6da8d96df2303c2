"""Environments with what a package declares, and nothing else.

Packages are linked file by file out of the environment that runs the tests: the registry is not
asked, and what is not declared is not there, neither its modules nor its metadata.
"""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from collections.abc import Iterable
from importlib.metadata import distribution
from pathlib import Path

from packaging.requirements import Requirement


def closure(requirements: Iterable[str]) -> set[str]:
    """Return the names of all packages that some requirements need, their own included.

    Raises:
        PackageNotFoundError: one of them is not installed here.
        AssertionError: one is installed in a version that is not asked for.
    """
    names: set[str] = set()
    coming = list(requirements)
    while coming:
        wanted = Requirement(coming.pop())
        extras = wanted.extras or {""}
        if wanted.marker and not wanted.marker.evaluate({"extra": ""}):
            continue
        package = distribution(wanted.name)
        assert wanted.specifier.contains(package.version, prereleases=True), str(wanted)
        if wanted.name in names:
            continue
        names.add(wanted.name)
        for text in package.requires or ():
            needed = Requirement(text)
            if needed.marker and not any(needed.marker.evaluate({"extra": e}) for e in extras):
                continue
            needed.marker = None
            coming.append(str(needed))
    return names


class EmptyEnvironment:
    """A virtual environment without packages, to which some are added.

    Attributes:
        python: its interpreter.
    """

    def __init__(self, folder: Path) -> None:
        """Make it; without pip, which the environment of the tests lends it."""
        venv.create(folder, with_pip=False, symlinks=True)
        self.python = folder / "bin" / "python"
        self._packages = next(folder.glob("lib/python*/site-packages"))

    def link(self, requirements: Iterable[str]) -> None:
        """Add everything that some requirements need."""
        for name in closure(requirements):
            package = distribution(name)
            for file in package.files or ():
                place = Path(os.path.normpath(self._packages / file))
                if file.suffix != ".pyc" and not place.exists():
                    place.parent.mkdir(parents=True, exist_ok=True)
                    place.symlink_to(Path(str(file.locate())).resolve())

    def install(self, wheel: Path) -> None:
        """Install a wheel with pip, which fails where a requirement is not there."""
        command = [sys.executable, "-m", "pip", "--python", self.python, "install", "--no-index"]
        self._run([*command, wheel], wheel.parent, None)

    def run(self, *arguments: str | Path, folder: Path) -> str:
        """Return what its Python prints, which must end well, with no other package in reach."""
        clean = {key: os.environ[key] for key in ("PATH", "HOME") if key in os.environ}
        clean["OMP_NUM_THREADS"] = "1"
        return self._run([self.python, *arguments], folder, clean)

    @staticmethod
    def _run(command: list[str | Path], folder: Path, env: dict[str, str] | None) -> str:
        """Return what a command prints; it must end well."""
        done = subprocess.run(
            command, cwd=folder, env=env, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-6000:]
        return done.stdout
