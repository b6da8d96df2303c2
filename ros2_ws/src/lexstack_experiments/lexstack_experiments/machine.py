"""On what a measurement was made: without names of machines."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from functools import cache

from lexstack_bag.run.provenance import UNKNOWN, installed_version, source_commit

_PACKAGES = ("numpy", "scipy", "pin", "daqp", "numba", "proxsuite", "mujoco")


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
            versions={name: installed_version(name) for name in _PACKAGES},
        )


@cache
def commit_here() -> str:
    """Return the commit of this source, with a plus sign where files differ; '' without git."""
    commit = source_commit()
    return "" if commit == UNKNOWN else commit[:10] + "+" * commit.endswith("+")
