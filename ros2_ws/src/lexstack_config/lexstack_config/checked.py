"""A scenario checked as a whole, with all that it names, before anything is started."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from lexstack.errors import ConfigurationError, InputError, ModelError
from lexstack.mpc import Reach, tasks_of
from lexstack.robots import RobotModel
from lexstack.tasks import plan_stack
from lexstack_config.event_targets import check_trajectories
from lexstack_config.folders import Folders
from lexstack_config.parts import Parts
from lexstack_config.resolved import ResolvedScenario


def checked(
    resolved: ResolvedScenario, folder: Path, path: Path | None = None, first: Sequence[Path] = ()
) -> ResolvedScenario:
    """Return a scenario of which robots, stacks and sequences are known to fit together.

    What a node would refuse when it starts is refused here. Stacks that do not fit the robots and
    that the scenario does not name move from ``stacks`` to ``unfit``.

    Args:
        resolved: as ``load_scenario`` returned it.
        folder: of the configuration, for the texts of errors.
        path: the scenario's file, for the texts of errors; None: its name.
        first: folders of the user's own, for the texts of errors.

    Raises:
        ConfigurationError: something does not fit; the text names file and key.
    """
    where = str(path or resolved.scenario.name)
    folders = Folders((folder,)) if path is None else Folders.around(path, first, folder)
    for model, config in resolved.robots.items():
        try:
            RobotModel(model, config)
        except ModelError as error:
            text = str(error).removeprefix(f"robot {model}: ")
            raise ConfigurationError(f"{folders.find('robots', model)}: {text}") from error
    parts = Parts.of(resolved, folders)
    _check_sequences(resolved, parts, where)
    check_trajectories(resolved.scenario, parts.team, where)
    stacks = {name: config for name, config in resolved.stacks.items() if name in parts.stacks}
    return replace(resolved, stacks=stacks, unfit=dict(parts.unfit))


def _check_sequences(resolved: ResolvedScenario, parts: Parts, where: str) -> None:
    """Raise ConfigurationError for a sequence that cannot be executed, naming its place."""
    scenario = resolved.scenario
    for name, config in scenario.sequences.items():
        place = f"{where}: sequences.{name}"
        stack = plan_stack(config.robot)
        if stack not in parts.stacks:
            why = parts.unfit.get(stack, "there is no such file")
            raise ConfigurationError(
                f"{place}: robot: {config.robot!r} follows plans on the stack {stack!r}: {why}"
            )
        robot = parts.team.robots[parts.team.index(config.robot)]
        base = scenario.robots[config.robot].base
        try:
            Reach(robot, parts.team.obstacles).check(tasks_of(config), config.architecture, base)
        except InputError as error:
            raise ConfigurationError(f"{place}: {error}") from error
