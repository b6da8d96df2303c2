"""What a bag says about its run besides the messages: the scenario, and who made it."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import lexstack
from lexstack_config.resolved import ResolvedScenario

_PACKAGES = {
    "numpy": "numpy",
    "mujoco": "mujoco",
    "scipy": "scipy",
    "daqp": "daqp",
    "numba": "numba",
    "proxsuite": "proxsuite",
    "casadi": "casadi",
    "pin": "pin",
    "example_robot_data": "example-robot-data",  # the robots' models
    "mcap": "mcap",
}
_PATIENCE = 5.0  # s for git to answer
UNKNOWN = "unknown"


def run_provenance(resolved: ResolvedScenario, namespace: str = "") -> dict[str, str]:
    """Return the keys of the Metadata record ``lexstack``.

    ``namespace`` is that of the run's topics, like /cell1, and stands there unless it is empty;
    ``scenario`` holds the resolved scenario's YAML; ``name``, ``mode`` and ``seed`` repeat what
    stands in it, for tools that do not parse it; ``commit`` is that of the source, with ``+`` where
    files have changed since; the rest are versions.
    """
    scenario = resolved.scenario
    return {
        "scenario": resolved.to_yaml(),
        "name": scenario.name,
        "mode": scenario.mode,
        "seed": str(scenario.seed),
        "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
        "commit": source_commit(),
        "machine": platform.machine(),
        "python": platform.python_version(),
        # A workspace has no metadata of its packages, so ours says its version itself.
        "lexstack": lexstack.__version__,
        **{key: installed_version(package) for key, package in _PACKAGES.items()},
        **({"namespace": namespace} if namespace else {}),
    }


def installed_version(package: str) -> str:
    """Return an installed package's version; a bag can be written where some are missing."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def source_commit() -> str:
    """Return the commit of this source, or that it is not known: an installed copy has none."""
    git = ["git", "-C", str(Path(__file__).resolve().parent)]
    try:
        commit, changes = (
            subprocess.run(
                [*git, *command], capture_output=True, text=True, check=True, timeout=_PATIENCE
            ).stdout
            for command in (["rev-parse", "HEAD"], ["status", "--porcelain", "-uno"])
        )
    except (OSError, subprocess.SubprocessError):
        return UNKNOWN
    return commit.strip() + ("+" if changes.strip() else "")
