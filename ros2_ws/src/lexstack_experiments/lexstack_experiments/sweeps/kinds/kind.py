"""What every kind of run is: a function of its values; and how a scenario takes values."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from lexstack.errors import ConfigurationError
from lexstack.options import shown
from lexstack_config.reader import build, plain
from lexstack_config.resolved import ResolvedScenario

_DIGITS = 10  # of a place in a list, fewer; Python makes no number of thousands

Row = dict[str, float | int | str | bool | None]
"""What a run has found, by the names of the figures (with their units)."""

Kind = Callable[[Path, str, Mapping[str, Any]], Row]
"""A run: of a configuration folder, what the sweep names, and values by key; with ``seed``."""


def with_values(resolved: ResolvedScenario, values: Mapping[str, Any]) -> ResolvedScenario:
    """Return a scenario with some of its values replaced.

    Args:
        resolved: the scenario.
        values: by the path of a key, such as ``scenario.transition.duration`` or
            ``stacks.track.tasks``; the first word may be left out where it is ``scenario``. An
            entry of a list has its number, as in ``events.0.at``.

    Raises:
        ConfigurationError: there is no such key, or the value does not fit; the text names it.
    """
    tree = plain(resolved)
    for path, value in values.items():
        parts = path.split(".")
        parts = parts if parts[0] in tree else ["scenario", *parts]
        place: Any = tree
        for part in parts[:-1]:
            place = place[_key(place, part, path)]
        place[_key(place, parts[-1], path)] = value
    return build(ResolvedScenario, tree, "the sweep's values")


def _key(place: Any, part: str, path: str) -> Any:
    """Return a word of a path as the key of a mapping or the place in a list."""
    if isinstance(place, dict) and part in place:
        return part
    if (
        isinstance(place, list)
        and part.isdecimal()
        and len(part) < _DIGITS
        and int(part) < len(place)
    ):
        return int(part)
    raise ConfigurationError(f"{shown(path)}: a scenario has no {shown(part)} there")


def column(name: str, unit: str = "") -> str:
    """Return a figure's name and unit as that of a column: letters, digits and underscores."""
    return re.sub(r"\W+", "_", f"{name} {unit}".strip()).strip("_").lower()
