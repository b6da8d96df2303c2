"""Range checks that the configuration's ``validate`` methods share."""

from __future__ import annotations

import math
from collections.abc import Iterable

from lexstack_core.errors import ConfigurationError


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


def _numbers(value: float | Iterable[float]) -> Iterable[float]:
    """Return one number or many as an iterable."""
    return (value,) if isinstance(value, int | float) else value
