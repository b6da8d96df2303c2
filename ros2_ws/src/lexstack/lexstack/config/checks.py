"""Range checks that the configuration's ``validate`` methods share."""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Iterable

from lexstack.errors import ConfigurationError

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")
_ROS_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
# A number for everybody but YAML 1.1: there an exponent needs its sign, and a point before it.
_ALMOST = re.compile(r"([-+]?)(\d{0,30})(\.\d{0,30})?[eE]([-+]?)(\d{1,4})")
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


def number_advice(value: object) -> str:
    """Return what to write where YAML takes a number for a text, as it does 1.0e9; else ''."""
    found = _ALMOST.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        return ""
    sign, whole, fraction, turn, exponent = found.groups()
    if not whole and fraction in (None, "."):
        return ""
    fraction = fraction if fraction not in (None, ".") else ".0"
    number = f"{sign}{whole or '0'}{fraction}e{turn or '+'}{exponent}"
    return f", which YAML reads as text: write {number}"


def _numbers(value: float | Iterable[float]) -> Iterable[float]:
    """Return one number or many as an iterable."""
    return (value,) if isinstance(value, int | float) else value
