"""From mappings, lists, texts and numbers to frozen dataclasses, strict in keys and types."""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from functools import cache
from typing import Annotated, Any, Literal, TypeVar

from lexstack.errors import ConfigurationError, NotANumberError
from lexstack.options.rules import shown

_T = TypeVar("_T")

_LARGEST = 2**63  # integers beyond it are mistakes

OLD_NAMES: dict[str, dict[str, str]] = {
    "HtmpcConfig": {
        "enough": "early_stop_ratio",
        "resume": "restart_from_previous",
        "correction": "second_order_correction",
    },
    "TaskConfig.type": {
        "distance": "collision_avoidance",
        "minimum_velocity": "velocity_damping",
    },
}
"""Old names that files may still use, and the new ones: keys of a class, values of a field."""


@cache
def hints(kind: type) -> dict[str, Any]:
    """Return the type of every field of a dataclass, with its ranges."""
    return typing.get_type_hints(kind, include_extras=True)  # slow: a scenario has 200 entries


def build(kind: type[_T], data: object, where: str) -> _T:
    """Return ``data`` as an instance of the dataclass ``kind``; every key known, every type right.

    Data that is such an instance already is checked as if it came from a file. A dataclass may
    define ``validate(where)``, which raises ConfigurationError; it runs last.
    """
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    if isinstance(data, kind):
        data = {name: getattr(data, name) for name in fields}
    if not isinstance(data, dict):
        raise ConfigurationError(f"{where}: expected a mapping of keys, got {shown(data)}")
    data = _renamed(data, OLD_NAMES.get(kind.__name__, {}), where)
    unknown = [str(key) for key in data if key not in fields]
    if unknown:
        raise ConfigurationError(
            f"{where}: unknown key {shown(unknown[0])}; known: {', '.join(sorted(fields))}"
        )
    values = {}
    kinds = hints(kind)  # type: ignore[arg-type]  # classes are hashable
    for name, field in fields.items():
        if name in data:
            values[name] = _convert(kinds[name], data[name], f"{where}: {name}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ConfigurationError(f"{where}: key {name!r} is missing")
    result = kind(**values)
    validate = getattr(result, "validate", None)
    if validate is not None:
        validate(where)
    return result


def _renamed(data: dict[Any, Any], old: dict[str, str], where: str) -> dict[Any, Any]:
    """Return a mapping with new names of its keys, each of which may stand in it once."""
    for name, new in old.items():
        if name in data and new in data:
            raise ConfigurationError(
                f"{where}: {name!r} is the old name of {new!r}: give one of them"
            )
    return {old.get(key, key): value for key, value in data.items()} if old else data


def _convert(hint: Any, value: object, where: str) -> Any:
    """Return ``value`` as the annotated type ``hint``; no silent conversions but int to float."""
    if dataclasses.is_dataclass(hint):
        return build(typing.cast("type", hint), value, where)
    return _CONVERSIONS.get(typing.get_origin(hint), _convert_scalar)(hint, value, where)


def _convert_ruled(hint: Any, value: object, where: str) -> Any:
    """Return a value that meets all rules of its type."""
    kind, *rules = typing.get_args(hint)
    result = _convert(kind, value, where)
    for rule in rules:
        rule.check(result, where)
    return result


def _convert_mapping(hint: Any, value: object, where: str) -> dict[str, Any]:
    """Return a mapping of names."""
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        raise ConfigurationError(f"{where}: expected a mapping of names, got {shown(value)}")
    key, item = typing.get_args(hint)
    names = [_convert(key, name, where) for name in value]
    return {name: _convert(item, value[name], f"{where}.{name}") for name in names}


def _convert_union(hint: Any, value: object, where: str) -> Any:
    """Return an optional value: None, or one of the other types.

    An error is that of the type which the value looks like.
    """
    options = [option for option in typing.get_args(hint) if option is not type(None)]
    if value is None and len(options) < len(typing.get_args(hint)):
        return None
    options = _by_type(options, value, where)
    errors = []
    for option in options:
        try:
            return _convert(option, value, where)
        except ConfigurationError as error:
            errors.append(error)
    looks = tuple if isinstance(value, list | tuple) else dict if isinstance(value, dict) else None
    origins = [typing.get_origin(option) for option in options]
    kinds = [origin if origin in (tuple, dict) else None for origin in origins]
    alike = [error for kind, error in zip(kinds, errors, strict=True) if kind is looks]
    raise (alike or errors)[-1]


def _by_type(options: list[Any], value: object, where: str) -> list[Any]:
    """Return the one of several dataclasses that a mapping names by its key ``type``.

    Without that key it is the first one. Other options are returned as they are.
    """
    kinds = [option for option in options if dataclasses.is_dataclass(option)]
    if len(kinds) < 2 or not isinstance(value, dict):
        return options
    names = [typing.get_args(hints(typing.cast("type", kind))["type"])[0] for kind in kinds]
    choice = Literal[tuple(names)]  # type: ignore[valid-type]
    chosen = _convert_choice(choice, value.get("type", names[0]), f"{where}: type")
    return [kinds[names.index(chosen)]]


def _convert_tuple(hint: Any, value: object, where: str) -> tuple[Any, ...]:
    """Return a list as a tuple; a fixed length is checked."""
    if not isinstance(value, list | tuple):
        raise ConfigurationError(f"{where}: expected a list, got {shown(value)}")
    items = typing.get_args(hint)
    if len(items) == 2 and items[1] is Ellipsis:
        return tuple(_convert(items[0], item, f"{where}[{i}]") for i, item in enumerate(value))
    if len(items) != len(value):
        raise ConfigurationError(f"{where}: expected {len(items)} values, got {len(value)}")
    return tuple(
        _convert(kind, item, f"{where}[{i}]")
        for i, (kind, item) in enumerate(zip(items, value, strict=True))
    )


def _convert_choice(hint: Any, value: object, where: str) -> Any:
    """Return ``value`` if it is one of the literals."""
    choices = typing.get_args(hint)
    if value not in choices:
        known = ", ".join(str(choice) for choice in choices)
        raise ConfigurationError(f"{where}: {shown(value)} is not one of: {known}")
    return value


def _convert_scalar(hint: Any, value: object, where: str) -> Any:
    """Return a bool, int, str or float (not NaN; ``.inf`` is legal where ``validate`` allows)."""
    if hint is str and isinstance(value, str):
        return _text(value, where)
    if hint is Any or (hint is bool and isinstance(value, bool)):
        return value
    if hint is int and isinstance(value, int) and not isinstance(value, bool):
        if abs(value) > _LARGEST:
            raise ConfigurationError(f"{where}: out of range, got {shown(value)}")
        return value
    if hint is float and isinstance(value, int | float) and not isinstance(value, bool):
        if math.isnan(value):
            raise ConfigurationError(f"{where}: must be a number, got NaN")
        if isinstance(value, int) and abs(value) > _LARGEST:
            raise ConfigurationError(f"{where}: out of range, got {shown(value)}")
        return float(value)
    text = f"{where}: expected {hint.__name__}, got {shown(value)}"
    raise NotANumberError(text, value) if hint in (int, float) else ConfigurationError(text)


def _text(value: str, where: str) -> str:
    """Return a text that can be printed and sent."""
    if not all(letter.isprintable() or letter == "\n" for letter in value):
        raise ConfigurationError(f"{where}: expected printable characters, got {shown(value)}")
    return value


_CONVERSIONS = {
    Annotated: _convert_ruled,
    types.UnionType: _convert_union,
    typing.Union: _convert_union,
    tuple: _convert_tuple,
    dict: _convert_mapping,
    typing.Literal: _convert_choice,
}
