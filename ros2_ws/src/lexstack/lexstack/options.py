"""Options: plain values as frozen dataclasses, strict in keys, types and ranges.

An option's dataclass checks its ranges in ``validate(where)``, with the checks of this module;
``build`` makes one from mappings, lists, texts and numbers, and says in every error where it stood.
"""

from __future__ import annotations

import dataclasses
import math
import re
import reprlib
import types
import typing
from collections.abc import Iterable
from functools import cache
from typing import Any, TypeVar

from lexstack.errors import ConfigurationError, NotANumberError

_T = TypeVar("_T")

_LARGEST = 2**63  # integers beyond it are mistakes
_hints = cache(typing.get_type_hints)  # a scenario has 200 entries of 30 kinds

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")
_ROS_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
_BRIEF = reprlib.Repr()
_BRIEF.maxstring = _BRIEF.maxother = 80


def positive(where: str, **values: float | Iterable[float]) -> None:
    """Raise ConfigurationError unless every value is finite and > 0."""
    for name, value in values.items():
        for number in _numbers(value):
            if not (math.isfinite(number) and number > 0.0):
                raise ConfigurationError(f"{where}: {name}: must be finite and > 0, got {number}")


def not_negative(where: str, **values: float | Iterable[float]) -> None:
    """Raise ConfigurationError unless every value is finite and >= 0."""
    for name, value in values.items():
        for number in _numbers(value):
            if not (math.isfinite(number) and number >= 0.0):
                raise ConfigurationError(f"{where}: {name}: must be finite and >= 0, got {number}")


def finite(where: str, **values: float | Iterable[float]) -> None:
    """Raise ConfigurationError unless every value is finite."""
    for name, value in values.items():
        for number in _numbers(value):
            if not math.isfinite(number):
                raise ConfigurationError(f"{where}: {name}: must be finite, got {number}")


def same_length(where: str, length: int, **values: tuple[float, ...]) -> None:
    """Raise ConfigurationError unless every list has ``length`` entries."""
    for name, value in values.items():
        if len(value) != length:
            raise ConfigurationError(f"{where}: {name}: expected {length} values, got {len(value)}")


def at_most(where: str, largest: float, **values: float) -> None:
    """Raise ConfigurationError unless every value is at most ``largest``."""
    for name, value in values.items():
        if value > largest:
            raise ConfigurationError(f"{where}: {name}: must be at most {largest:g}, got {value:g}")


def names(where: str, *, ros: bool = False, **values: str | Iterable[str]) -> None:
    """Raise ConfigurationError unless every name may be (a part of) a file's name.

    ``ros``: and of a topic's.
    """
    form = _ROS_NAME if ros else _NAME
    letters = "letters, digits and _" if ros else "letters, digits, _ and -"
    for key, value in values.items():
        for name in (value,) if isinstance(value, str) else value:
            if not form.fullmatch(name):
                raise ConfigurationError(
                    f"{where}: {key}: a name has {letters}, begins with a letter "
                    f"and has at most 64 characters, got {shown(name)}"
                )


def shown(value: object) -> str:
    """Return a value as it may stand in an error: one line, not long, whatever it is."""
    try:
        return _BRIEF.repr(value)
    except ValueError:  # an integer of more digits than Python prints
        return f"a {type(value).__name__} that is too long to show"


def _numbers(value: float | Iterable[float]) -> Iterable[float]:
    """Return one number or many as an iterable."""
    return (value,) if isinstance(value, int | float) else value


def build(kind: type[_T], data: object, where: str) -> _T:
    """Return ``data`` as an instance of the dataclass ``kind``; every key known, every type right.

    A dataclass may define ``validate(where)``, which raises ConfigurationError; it runs last.
    """
    if not isinstance(data, dict):
        raise ConfigurationError(f"{where}: expected a mapping of keys, got {shown(data)}")
    hints = _hints(kind)  # type: ignore[arg-type]  # classes are hashable
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    unknown = [str(key) for key in data if key not in fields]
    if unknown:
        raise ConfigurationError(
            f"{where}: unknown key {shown(unknown[0])}; known: {', '.join(sorted(fields))}"
        )
    values = {}
    for name, field in fields.items():
        if name in data:
            values[name] = _convert(hints[name], data[name], f"{where}: {name}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ConfigurationError(f"{where}: key {name!r} is missing")
    result = kind(**values)
    validate = getattr(result, "validate", None)
    if validate is not None:
        validate(where)
    return result


def _convert(hint: Any, value: object, where: str) -> Any:
    """Return ``value`` as the annotated type ``hint``; no silent conversions but int to float."""
    origin = typing.get_origin(hint)
    if origin in (types.UnionType, typing.Union):
        return _convert_union(hint, value, where)
    if origin is tuple:
        return _convert_tuple(hint, value, where)
    if origin is dict:
        if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
            raise ConfigurationError(f"{where}: expected a mapping of names, got {shown(value)}")
        item = typing.get_args(hint)[1]
        return {key: _convert(item, entry, f"{where}.{key}") for key, entry in value.items()}
    if origin is typing.Literal:
        return _convert_choice(typing.get_args(hint), value, where)
    if dataclasses.is_dataclass(hint):
        return build(typing.cast("type", hint), value, where)
    return _convert_scalar(hint, value, where)


def _convert_union(hint: Any, value: object, where: str) -> Any:
    """Return an optional value: None, or one of the other types.

    An error is that of the type which the value looks like.
    """
    options = [option for option in typing.get_args(hint) if option is not type(None)]
    if value is None and len(options) < len(typing.get_args(hint)):
        return None
    errors = []
    for option in options:
        try:
            return _convert(option, value, where)
        except ConfigurationError as error:
            errors.append(error)
    looks = tuple if isinstance(value, list | tuple) else dict if isinstance(value, dict) else None
    alike = [
        error
        for option, error in zip(options, errors, strict=True)
        if (typing.get_origin(option) is looks if looks else isinstance(error, NotANumberError))
    ]
    raise (alike or errors)[-1]


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


def _convert_choice(choices: tuple[Any, ...], value: object, where: str) -> Any:
    """Return ``value`` if it is one of the literal ``choices``."""
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
