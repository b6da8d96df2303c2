"""A run with robots of the user's own in place of the simulation."""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass, replace
from pathlib import Path

from lexstack.errors import ConfigurationError
from lexstack_config.folders import Folders
from lexstack_config.plant_file import PlantFile, check_plant, find_plant, load_plant
from lexstack_config.resolved import ResolvedScenario


@dataclass(frozen=True, slots=True)
class RealPlant:
    """The robots of a run.

    Attributes:
        path: of the plant file.
        plant: what is in it.
        enable: whether the run enables them; else their user does.
    """

    path: Path
    plant: PlantFile
    enable: bool

    def applied(self, resolved: ResolvedScenario) -> ResolvedScenario:
        """Return a scenario as it runs with these robots: in realtime, at their rate."""
        scenario = replace(resolved.scenario, mode="realtime", rate=self.plant.rate)
        return replace(resolved, scenario=scenario)


def real_plant(
    root: Path, options: argparse.Namespace, resolved: ResolvedScenario
) -> RealPlant | None:
    """Return the robots that the command line names, or None.

    Raises:
        ConfigurationError: the file is wrong, or has not the robots of the scenario.
    """
    if options.plant is None:
        if options.enable:
            raise ConfigurationError("--enable: only robots of --plant are enabled")
        return None
    config = root / "config"
    folders = Folders(tuple(dict.fromkeys((*options.config, config))))
    path = find_plant(options.plant, folders).resolve()
    plant = load_plant(path)
    check_plant(plant, resolved, str(path))
    return RealPlant(path, plant, options.enable)


def robots_domain() -> int:
    """Return the ROS_DOMAIN_ID of the robots: the environment's, or that of ROS by default."""
    given = os.environ.get("ROS_DOMAIN_ID", "0")
    if not given.isdecimal() or int(given) > 232:
        raise ConfigurationError(f"ROS_DOMAIN_ID: must be a number from 0 to 232, got {given!r}")
    return int(given)
