"""What a replay is asked: a run, and what if some values of its scenario were others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from lexstack.errors import ConfigurationError
from lexstack.options import OLD_NAMES
from lexstack_bag.run.run import Run
from lexstack_bag.storage.container import Progress
from lexstack_config.extensions import load_extensions
from lexstack_config.reader import build, plain
from lexstack_config.resolved import ResolvedScenario

_ROOTS = ("scenario", "robots", "stacks", "htmpc")


@dataclass(frozen=True, slots=True)
class Changes:
    """What shall be other than it was.

    Attributes:
        settings: ``KEY=VALUE`` each, KEY a path of names and numbers with dots between them, from
            ``scenario``, ``robots``, ``stacks`` or ``htmpc``, or from inside the scenario; VALUE is
            YAML.
        method: of all transitions; empty: as recorded.
        stack: ``NAME``: every switch goes there; ``OLD=NEW``: those to OLD; empty: as recorded.
        solver: of all problems; empty: as recorded.
    """

    settings: tuple[str, ...] = ()
    method: str = ""
    stack: str = ""
    solver: str = ""

    def __bool__(self) -> bool:
        """Return whether anything changes."""
        return self != Changes()

    def __str__(self) -> str:
        """Return the changes in one line."""
        named = [("method", self.method), ("stack", self.stack), ("solver", self.solver)]
        return ", ".join([*self.settings, *(f"{key}={value}" for key, value in named if value)])

    def applied(self, resolved: ResolvedScenario) -> ResolvedScenario:
        """Return a scenario with the changes made; raises ConfigurationError."""
        settings = list(self.settings)
        if self.method:
            settings.append(f"scenario.transition.method={self.method}")
        if self.solver:
            settings.append(f"scenario.solver={self.solver}")
        tree = plain(resolved)
        for setting in settings:
            _set(tree, setting)
        changed = build(ResolvedScenario, tree, "--set")
        load_extensions(changed.scenario, str(self))
        _, new = self.stacks(changed)
        if new and new not in changed.stacks:
            known = ", ".join(sorted(changed.stacks))
            raise ConfigurationError(f"--stack: unknown {new!r}; known: {known}")
        return changed

    def stacks(self, resolved: ResolvedScenario) -> tuple[str, str]:
        """Return which stack is replaced (empty: each) and by which (empty: none)."""
        old, mark, new = self.stack.partition("=")
        if mark and old not in resolved.stacks:
            known = ", ".join(sorted(resolved.stacks))
            raise ConfigurationError(f"--stack: unknown {old!r}; known: {known}")
        return (old, new) if mark else ("", self.stack)


@dataclass(frozen=True, slots=True)
class Question:
    """What to replay.

    Attributes:
        run: the recorded run.
        changes: what shall be other than it was.
        resolved: the scenario with the changes made.
        progress: told how much is done, from 0 to 1.
    """

    run: Run
    changes: Changes
    resolved: ResolvedScenario
    progress: Progress = lambda _part: None


_DIGITS = 10  # of a place in a list, fewer; Python makes no number of thousands


def _set(tree: dict[str, Any], setting: str) -> None:
    """Put one ``KEY=VALUE`` into the plain scenario; raises ConfigurationError."""
    key, mark, text = setting.partition("=")
    if not mark or not key:
        raise ConfigurationError(f"--set: expected KEY=VALUE, got {setting!r}")
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ConfigurationError(f"--set: {key}: not valid YAML: {text!r}") from error
    path = key.split(".")
    if path[0] not in _ROOTS:
        path = ["scenario", *path]
    place: Any = tree
    for depth, name in enumerate(path[:-1]):
        place = place[_index(place, name, path[:depth])]
    last = path[-1]
    # Parameters of tasks are open: each type of task knows its own, and checks them.
    place[last if path[-2] == "parameters" else _index(place, last, path[:-1])] = value


def _index(place: Any, name: str, path: Sequence[str]) -> str | int:
    """Return a name as an index of a mapping or list; raises ConfigurationError listing them."""
    where = ".".join(path) or "the scenario"
    if isinstance(place, list):
        if name.isdecimal() and len(name) < _DIGITS and int(name) < len(place):
            return int(name)
        raise ConfigurationError(f"--set: {where}: no entry {name!r}; it has {len(place)}")
    if isinstance(place, dict):
        new = [names[name] for names in OLD_NAMES.values() if name in names]
        for key in (name, *new):
            if key in place:
                return key
        known = ", ".join(str(key) for key in place) or "nothing"
        raise ConfigurationError(f"--set: {where}: unknown key {name!r}; known: {known}")
    raise ConfigurationError(f"--set: {where}: is a value, it has no {name!r}")
