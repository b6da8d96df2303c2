"""What the live page may ask for: read from JSON, every field checked."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from lexstack.errors import InputError

_FARTHEST = 100.0  # m
_LONGEST = 60.0  # s
_STRONGEST = 1000.0  # N


@dataclass(frozen=True, slots=True)
class Switch:
    """Switch to a stack; duration [s], 0: from the configuration."""

    stack: str
    duration: float


@dataclass(frozen=True, slots=True)
class Cancel:
    """Go back from the transition that is under way."""


@dataclass(frozen=True, slots=True)
class NewTarget:
    """A new reference: of the end effector x, y, z [m]; of the base x [m], y [m], yaw [rad]."""

    robot: str
    kind: str  # "ee" or "base"
    values: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Push:
    """A force [N] in the world frame on a link for a duration [s] of simulated time."""

    robot: str
    link: str  # "base" or "tool"
    force: tuple[float, float, float]
    duration: float


Order = Switch | Cancel | NewTarget | Push


def read_order(text: bytes, robots: Collection[str], stacks: Collection[str]) -> Order:
    """Return the order in a JSON object.

    Raises:
        InputError: it is none; the text names the field.
    """
    try:
        content = json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not JSON: {error}") from error
    if not isinstance(content, dict):
        raise InputError("expected a JSON object")
    readers = {
        "switch": lambda: Switch(
            _one_of(content, "stack", stacks), _number(content, "duration", 0.0, _LONGEST)
        ),
        "cancel": Cancel,
        "target": lambda: NewTarget(
            _one_of(content, "robot", robots),
            _one_of(content, "kind", ("ee", "base")),
            _three(content, "values", _FARTHEST),
        ),
        "push": lambda: Push(
            _one_of(content, "robot", robots),
            _one_of(content, "link", ("base", "tool")),
            _three(content, "force", _STRONGEST),
            _number(content, "duration", 0.001, _LONGEST),
        ),
    }
    return readers[_one_of(content, "do", readers)]()


def _one_of(content: Mapping[str, Any], key: str, known: Collection[str]) -> str:
    """Return one of the known words."""
    value = content.get(key)
    if not isinstance(value, str) or value not in known:
        raise InputError(f"{key}: expected one of {', '.join(known)}, got {value!r:.80}")
    return value


def _number(content: Mapping[str, Any], key: str, lower: float, upper: float) -> float:
    """Return a number within limits."""
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key}: expected a number, got {value!r:.80}")
    if not lower <= value <= upper:
        raise InputError(f"{key}: must be from {lower:g} to {upper:g}, got {value:g}")
    return float(value)


def _three(content: Mapping[str, Any], key: str, most: float) -> tuple[float, float, float]:
    """Return three numbers of at most ``most``."""
    values = content.get(key)
    if not isinstance(values, list) or len(values) != 3:
        raise InputError(f"{key}: expected three numbers, got {values!r:.80}")
    first, second, third = (
        _number({f"{key}[{i}]": value}, f"{key}[{i}]", -most, most)
        for i, value in enumerate(values)
    )
    return first, second, third


def _refuse(word: str) -> float:
    """Refuse NaN and Infinity, which are no JSON."""
    raise ValueError(f"{word} is no number")
