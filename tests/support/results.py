"""What results.json of experiments and benches holds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any


def numbers(value: Any) -> Iterator[float]:
    """Yield every number in a decoded JSON value."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for entry in value:
            yield from numbers(entry)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield value
