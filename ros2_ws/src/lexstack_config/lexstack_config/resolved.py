"""A scenario with everything it names, loaded: what a run needs, and what its bag carries."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import yaml

import lexstack.robots
from lexstack.errors import ConfigurationError
from lexstack.mpc import HtmpcConfig
from lexstack.options import shown
from lexstack.robots import RobotConfig
from lexstack.tasks import StackConfig
from lexstack_config.available import available, load_stack
from lexstack_config.extensions import load_extensions
from lexstack_config.folders import Folders
from lexstack_config.reader import build, parse_yaml, plain, read_yaml
from lexstack_config.scenario import ScenarioConfig


@dataclass(frozen=True, slots=True)
class ResolvedScenario:
    """A scenario, the kinds of robots that it uses, and every stack that can be asked for."""

    scenario: ScenarioConfig
    robots: dict[str, RobotConfig]  # by model name
    stacks: dict[str, StackConfig]  # by stack name
    htmpc: dict[str, HtmpcConfig] = field(default_factory=dict)  # by name of the parameters
    unfit: dict[str, str] = field(default_factory=dict)  # by name of a stack: why it does not fit

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a robot or stack that is named but not there."""
        for name, placement in self.scenario.robots.items():
            _known(f"{where}: robots.{name}.model", placement.model, self.robots)
        self._check_bases(where)
        self._check_stack(f"{where}: initial_stack", self.scenario.initial_stack)
        for i, event in enumerate(self.scenario.events):
            if event.switch:
                self._check_stack(f"{where}: events[{i}].switch", event.switch)
        moved = self.stacks[self.scenario.initial_stack].robots
        left = [name for name in self.scenario.robots if moved and name not in moved]
        if left:
            raise ConfigurationError(
                f"{where}: initial_stack: {self.scenario.initial_stack!r} leaves "
                f"{', '.join(left)} without a stack"
            )

    def _check_bases(self, where: str) -> None:
        """Raise ConfigurationError for a base that a robot has not, or a base in the air."""
        scenario = self.scenario
        mounted = {
            name for name, place in scenario.robots.items() if self.robots[place.model].base is None
        }
        asked: list[tuple[str, Mapping[str, object]]] = [("base_target", scenario.base_target)]
        for i, event in enumerate(scenario.events):
            asked.append((f"events[{i}].base_target", event.base_target))
            asked.append((f"events[{i}].base_path", event.base_path))
        for i, stream in enumerate(scenario.streams):
            if stream.target == "base":
                asked.append((f"streams[{i}].target", {stream.robot: stream.swing}))
        for key, targets in asked:
            for name in mounted.intersection(targets):
                raise ConfigurationError(f"{where}: {key}: robot {name!r} has no base")
        for name, place in scenario.robots.items():
            if name not in mounted and place.z:
                raise ConfigurationError(
                    f"{where}: robots.{name}.z: only a robot without a base has a height"
                )

    def _check_stack(self, where: str, name: str) -> None:
        """Raise ConfigurationError for a stack that is not there, or does not fit."""
        if name in self.unfit:
            raise ConfigurationError(f"{where}: {shown(name)} does not fit: {self.unfit[name]}")
        _known(where, name, self.stacks)

    def to_yaml(self) -> str:
        """Return the whole as one YAML text, which ``from_yaml`` reads again."""
        return yaml.safe_dump(plain(self), sort_keys=False, allow_unicode=True)

    @classmethod
    def from_yaml(
        cls, text: str, where: str, since: Mapping[str, Mapping[str, object]] | None = None
    ) -> ResolvedScenario:
        """Return the scenario in a text that ``to_yaml`` wrote.

        Args:
            text: YAML.
            where: its origin, for errors.
            since: values of keys that older versions did not write: of the ``scenario``, and of
                each set of parameters of the ``htmpc``.
        """
        tree = parse_yaml(text, where)
        if since and isinstance(tree, dict):
            _fill(tree, "scenario", since.get("scenario", {}))
            for name in _mapping(tree.get("htmpc")):
                _fill(tree["htmpc"], name, since.get("htmpc", {}))
        return build(cls, tree, where)


def _mapping(value: object) -> dict[str, object]:
    """Return a mapping of a file; an empty one in place of anything else."""
    return value if isinstance(value, dict) else {}


def _fill(tree: dict[str, object], key: str, values: Mapping[str, object]) -> None:
    """Set the values that a mapping under a key does not have."""
    if isinstance(tree.get(key), dict):
        tree[key] = {**values, **_mapping(tree[key])}


def load_scenario(
    path: Path, config: Path | None = None, first: Sequence[Path] = ()
) -> ResolvedScenario:
    """Return a scenario file with its robots and the stacks of the configuration folders.

    Files are searched for in the folders ``first``, then in the scenario's own, then in ``config``.
    The ``scenario.yaml`` of a run's folder, which has all of them in it, is read as it is.

    A stack file that is wrong, that names robots which the scenario has not, or whose limits are
    for another kind of robot is left out, and ``unfit`` says why; not if the scenario names it.

    Args:
        path: the scenario's file.
        config: the folder with ``robots/`` and ``stacks/``; default: the one above the scenario's.
        first: folders of the user's own.

    Raises:
        ConfigurationError: a file is missing or wrong, or an extension; the text names the file
            and the key.
    """
    tree = read_yaml(path)
    if isinstance(tree.get("scenario"), dict):
        whole = build(ResolvedScenario, tree, str(path))
        load_extensions(whole.scenario, str(path))
        return replace(whole, unfit={})
    folders = Folders.around(path, first, config)
    scenario = build(ScenarioConfig, tree, str(path))
    load_extensions(scenario, str(path))
    robots = {
        model: load_robot(folders.find("robots", model))
        for model in dict.fromkeys(place.model for place in scenario.robots.values())
    }
    stacks, unfit = available(folders, scenario, robots, str(path))
    parameters = _parameters(folders, scenario)
    resolved = ResolvedScenario(scenario, robots, stacks, parameters, unfit)
    resolved.validate(str(path))
    return resolved


def _parameters(folders: Folders, scenario: ScenarioConfig) -> dict[str, HtmpcConfig]:
    """Return the parameters of the HTMPC that a scenario names, if it runs one."""
    if not scenario.plans:
        return {}
    name = scenario.htmpc.parameters
    return {name: load_htmpc(folders.find("htmpc", name))}


def load_robot(path: Path) -> RobotConfig:
    """Return one robot file, with every value in it that the file leaves out.

    Raises:
        ConfigurationError: the file or the URDF is missing or wrong; the text names file and key.
    """
    # By way of the package, which loads pinocchio now: a recorder has no need of it.
    file = build(lexstack.robots.RobotFile, read_yaml(path), str(path))
    if file.name != path.stem:
        raise ConfigurationError(f"{path}: name: expected {path.stem!r}, got {shown(file.name)}")
    return lexstack.robots.completed(file, str(path), path.resolve().parent)


def load_stacks(folder: Path) -> dict[str, StackConfig]:
    """Return every stack file of a folder, by name."""
    files = sorted(folder.glob("*.yaml"))
    return {path.stem: load_stack(path) for path in files}


def _known(where: str, name: str, known: Collection[str]) -> None:
    """Raise ConfigurationError unless ``name`` is a key of ``known``."""
    if name not in known:
        listed = ", ".join(sorted(known))
        raise ConfigurationError(f"{where}: unknown {shown(name)}; known: {listed}")


def load_htmpc(path: Path) -> HtmpcConfig:
    """Return one file of ``config/htmpc``; raises ConfigurationError with file and key."""
    config = build(HtmpcConfig, read_yaml(path), str(path))
    if config.name != path.stem:
        raise ConfigurationError(f"{path}: name: expected {path.stem!r}, got {shown(config.name)}")
    return config
