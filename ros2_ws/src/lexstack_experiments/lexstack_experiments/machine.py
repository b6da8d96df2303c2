"""On what a measurement was made: without names of machines."""

from __future__ import annotations

import os
import platform
import subprocess
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_PACKAGES = ("numpy", "scipy", "pin", "daqp", "proxsuite", "mujoco")


@dataclass(frozen=True, slots=True)
class Machine:
    """Cores that may be used, kind of processor, system, Python, versions of what computes."""

    cores: int
    processor: str
    system: str
    python: str
    versions: dict[str, str]

    @classmethod
    def here(cls) -> Machine:
        """Return the present machine."""
        return cls(
            cores=len(os.sched_getaffinity(0)),
            processor=platform.machine(),
            system=platform.system(),
            python=platform.python_version(),
            versions={name: _version(name) for name in _PACKAGES},
        )


def _version(package: str) -> str:
    """Return the version of an installed package, or that there is none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


@cache
def commit_here() -> str:
    """Return the commit of this source, with a plus sign where files differ; '' without git."""
    git = ["git", "-C", str(Path(__file__).resolve().parent)]
    try:
        commit = _told([*git, "rev-parse", "--short=10", "HEAD"])
        return commit + "+" * bool(_told([*git, "status", "--porcelain", "-uno"]))
    except (OSError, subprocess.CalledProcessError):
        return ""


def _told(command: list[str]) -> str:
    """Return what a command prints."""
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.strip()
