"""On what a measurement was made: without names of machines."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

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
