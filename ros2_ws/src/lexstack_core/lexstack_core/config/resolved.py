"""A scenario with everything it names, loaded: what a run needs, and what its bag carries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import yaml

from lexstack_core.config.checks import shown
from lexstack_core.config.htmpc import HtmpcConfig, load_htmpc
from lexstack_core.config.reader import build, parse_yaml, plain, read_yaml
from lexstack_core.config.robot import RobotConfig
from lexstack_core.config.scenario import ScenarioConfig
from lexstack_core.config.stack import StackConfig
from lexstack_core.errors import ConfigurationError

T = TypeVar("T", RobotConfig, StackConfig)


@dataclass(frozen=True, slots=True)
class ResolvedScenario:
    """A scenario, the kinds of robots that it uses, and every stack that can be asked for."""

    scenario: ScenarioConfig
    robots: dict[str, RobotConfig]  # by model name
    stacks: dict[str, StackConfig]  # by stack name
    htmpc: dict[str, HtmpcConfig] = field(default_factory=dict)  # by name of the parameters

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a robot or stack that is named but not there."""
        for name, placement in self.scenario.robots.items():
            _known(f"{where}: robots.{name}.model", placement.model, self.robots)
        _known(f"{where}: initial_stack", self.scenario.initial_stack, self.stacks)
        for i, event in enumerate(self.scenario.events):
            if event.switch:
                _known(f"{where}: events[{i}].switch", event.switch, self.stacks)
        moved = self.stacks[self.scenario.initial_stack].robots
        left = [name for name in self.scenario.robots if moved and name not in moved]
        if left:
            raise ConfigurationError(
                f"{where}: initial_stack: {self.scenario.initial_stack!r} leaves "
                f"{', '.join(left)} without a stack"
            )

    def to_yaml(self) -> str:
        """Return the whole as one YAML text, which ``from_yaml`` reads again."""
        return yaml.safe_dump(plain(self), sort_keys=False, allow_unicode=True)

    @classmethod
    def from_yaml(
        cls, text: str, where: str, since: Mapping[str, object] | None = None
    ) -> ResolvedScenario:
        """Return the scenario in a text that ``to_yaml`` wrote.

        Args:
            text: YAML.
            where: its origin, for errors.
            since: values of the scenario's keys that older versions did not write.
        """
        tree = parse_yaml(text, where)
        if since and isinstance(tree, dict) and isinstance(tree.get("scenario"), dict):
            tree["scenario"] = {**since, **tree["scenario"]}
        return build(cls, tree, where)


def load_scenario(path: Path, config: Path | None = None) -> ResolvedScenario:
    """Return a scenario file with its robots and the stacks of the configuration folder.

    A stack that names robots which the scenario has not is left out, as is one whose limits are
    for another kind of robot.

    Args:
        path: the scenario's file.
        config: the folder with ``robots/`` and ``stacks/``; default: the one above the scenario's.

    Raises:
        ConfigurationError: a file is missing or wrong; the text names the file and the key.
    """
    folder = path.resolve().parent.parent if config is None else config
    scenario = build(ScenarioConfig, read_yaml(path), str(path))
    robots = {
        model: load_robot(folder / "robots" / f"{model}.yaml")
        for model in dict.fromkeys(place.model for place in scenario.robots.values())
    }
    resolved = ResolvedScenario(
        scenario,
        robots,
        _fitting(scenario, load_stacks(folder / "stacks"), robots, str(path)),
        _parameters(folder / "htmpc", scenario),
    )
    resolved.validate(str(path))
    return resolved


def _fitting(
    scenario: ScenarioConfig,
    stacks: dict[str, StackConfig],
    robots: dict[str, RobotConfig],
    where: str,
) -> dict[str, StackConfig]:
    """Return the stacks whose robots a scenario has; raise ConfigurationError if it needs others.

    Args:
        scenario: with its robots, and the stacks that it names.
        stacks: of the configuration folder.
        robots: by model name.
        where: the scenario's file.
    """
    wanted = {scenario.initial_stack, *(event.switch for event in scenario.events)}
    fitting = {}
    for name, stack in stacks.items():
        absent = [robot for robot in stack.named if robot not in scenario.robots]
        if not absent:
            if name in wanted or not _for_others(stack, scenario, robots):
                fitting[name] = stack
        elif name in wanted:
            raise ConfigurationError(
                f"{where}: stack {name!r} names robots that the scenario has not: "
                f"{', '.join(absent)}"
            )
    return fitting


def _for_others(
    stack: StackConfig, scenario: ScenarioConfig, robots: dict[str, RobotConfig]
) -> bool:
    """Return whether a stack limits joints of a robot of which that has not a single one."""
    for name, limits in stack.limits.items():
        arm = robots[scenario.robots[name].model].arm.joints
        if limits and not any(joint in arm or joint.startswith("base_") for joint in limits):
            return True
    return False


def _parameters(folder: Path, scenario: ScenarioConfig) -> dict[str, HtmpcConfig]:
    """Return the parameters of the HTMPC that a scenario names, if it runs one."""
    if not scenario.plans:
        return {}
    name = scenario.htmpc.parameters
    return {name: load_htmpc(folder / f"{name}.yaml")}


def load_robot(path: Path) -> RobotConfig:
    """Return one robot file."""
    return _named(build(RobotConfig, read_yaml(path), str(path)), path)


def load_stacks(folder: Path) -> dict[str, StackConfig]:
    """Return every stack file of a folder, by name."""
    files = sorted(folder.glob("*.yaml"))
    return {
        path.stem: _named(build(StackConfig, read_yaml(path), str(path)), path) for path in files
    }


def _named(config: T, path: Path) -> T:
    """Return ``config`` if it bears its file's name."""
    if config.name != path.stem:
        raise ConfigurationError(f"{path}: name: expected {path.stem!r}, got {shown(config.name)}")
    return config


def _known(where: str, name: str, known: dict[str, T]) -> None:
    """Raise ConfigurationError unless ``name`` is a key of ``known``."""
    if name not in known:
        listed = ", ".join(sorted(known))
        raise ConfigurationError(f"{where}: unknown {shown(name)}; known: {listed}")
