"""Which stacks of a folder a scenario can ask for, and why it cannot ask for the others."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import lexstack.robots
from lexstack.errors import ConfigurationError
from lexstack.options import shown
from lexstack.robots import RobotConfig
from lexstack.tasks import StackConfig
from lexstack_config.folders import Folders
from lexstack_config.reader import build, read_yaml
from lexstack_config.scenario import ScenarioConfig

FOR_OTHERS = "is for other robots: "
"""Begins the reason of a stack in which nothing is wrong, but whose robots a scenario has not."""


def load_stack(path: Path) -> StackConfig:
    """Return one stack file; raises ConfigurationError with file and key."""
    config = build(StackConfig, read_yaml(path), str(path))
    if config.name != path.stem:
        raise ConfigurationError(f"{path}: name: expected {path.stem!r}, got {shown(config.name)}")
    return config


def available(
    folders: Folders, scenario: ScenarioConfig, robots: Mapping[str, RobotConfig], where: str
) -> tuple[dict[str, StackConfig], dict[str, str]]:
    """Return the stacks that a scenario can ask for, and by name why the other files do not fit.

    A file that the scenario does not name must not keep it from running, whatever is in it.

    Args:
        folders: of the configuration, with ``stacks/``.
        scenario: with its robots, and the stacks that it names.
        robots: by model name.
        where: the scenario's file.

    Raises:
        ConfigurationError: a stack that the scenario names is wrong, or names robots that the
            scenario has not.
    """
    stacks, unfit = {}, {}
    there = folders.all("stacks", [name for name in scenario.stacks_named if name.strip("/.")])
    for name, path in there.items():
        wanted = name in scenario.stacks_named
        if wanted and not path.exists():
            continue  # it is missed where it is asked for
        try:
            stack = load_stack(path)
        except ConfigurationError as error:
            if wanted:
                raise
            unfit[name] = without_folder(str(error), path.parent.parent)
            continue
        absent = [robot for robot in stack.named if robot not in scenario.robots]
        if absent and wanted:
            raise ConfigurationError(
                f"{where}: stack {name!r} names robots that the scenario has not: "
                f"{', '.join(absent)}"
            )
        if absent:
            unfit[name] = f"{FOR_OTHERS}the scenario has not {', '.join(absent)}"
            continue
        strangers = "" if wanted else _for_others(stack, scenario, robots)
        if strangers:
            unfit[name] = FOR_OTHERS + strangers
        else:
            stacks[name] = stack
    return stacks, unfit


def without_folder(text: str, folder: Path) -> str:
    """Return a text with paths that begin at the configuration folder's name.

    Bags carry such a text to other machines, where the folders above mean nothing.
    """
    return text.replace(f"{folder.parent}/", "") if folder.name else text


def _for_others(
    stack: StackConfig, scenario: ScenarioConfig, robots: Mapping[str, RobotConfig]
) -> str:
    """Return which joints a stack limits of a robot that has not a single one of them, or ''."""
    for name, limits in stack.limits.items():
        robot = robots[scenario.robots[name].model]
        base: tuple[str, ...] = ()
        if robot.base is not None:
            differential = robot.base.type == "differential"
            base = lexstack.robots.DRIVE if differential else lexstack.robots.BASE_JOINTS
        if limits and not {*base, *robot.arm.joints}.intersection(limits):
            return f"{name} has not {', '.join(limits)}"
    return ""
