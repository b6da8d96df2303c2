"""What a bag says about its run besides the messages: the scenario, and who made it."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version

from lexstack_core.config.resolved import ResolvedScenario

_PACKAGES = {
    "lexstack": "lexstack-core",
    "numpy": "numpy",
    "mujoco": "mujoco",
    "daqp": "daqp",
    "pin": "pin",
}


def run_facts(resolved: ResolvedScenario) -> dict[str, str]:
    """Return the keys of the Metadata record ``lexstack``.

    ``scenario`` holds the resolved scenario's YAML; ``name``, ``mode`` and ``seed`` repeat what
    stands in it, for tools that do not parse it; the rest are versions.
    """
    scenario = resolved.scenario
    return {
        "scenario": resolved.to_yaml(),
        "name": scenario.name,
        "mode": scenario.mode,
        "seed": str(scenario.seed),
        "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
        "python": platform.python_version(),
        **{key: _version(package) for key, package in _PACKAGES.items()},
    }


def _version(package: str) -> str:
    """Return an installed package's version; a bag can be written where some are missing."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
