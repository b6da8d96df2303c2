"""From a list of decoded messages to the arrays of a stream, one array per field."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from lexstack_bag.run import ChiStream, PlantStream, TransitionStream, read_only

T = TypeVar("T", PlantStream, ChiStream, TransitionStream)


def stream(kind: type[T], messages: Sequence[Any], n: int) -> T:
    """Return the stream of messages whose fields bear the names of the stream's fields.

    Args:
        kind: the stream's class; its annotations say how each column is made.
        messages: decoded messages in the order of their arrival.
        n: length of chi; a vector of another length (a failed solve has none) becomes nan.
    """
    columns = {}
    for field in dataclasses.fields(kind):
        values = [_value(message, field.name) for message in messages]
        columns[field.name] = _COLUMNS[str(field.type)](values, n)
    return kind(**columns)


def one_per_tick(messages: Sequence[Any]) -> list[Any]:
    """Return the messages after the last reset of the plant, the first of each tick, ascending.

    The tick starts again at a reset; while the plant is paused a tick may be told twice.
    """
    ticks = np.array([message.tick for message in messages], dtype=np.int64)
    resets = np.flatnonzero(np.diff(ticks) < 0)
    first = int(resets[-1]) + 1 if len(resets) else 0
    _, index = np.unique(ticks[first:], return_index=True)
    return [messages[first + int(i)] for i in index]


def seconds(stamp: Any) -> float:
    """Return a ROS time in seconds."""
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def _value(message: Any, name: str) -> Any:
    """Return a field of a message; the stamp stands in its header."""
    return seconds(message.header.stamp) if name == "stamp" else getattr(message, name)


def _rows(values: Sequence[Any], n: int) -> Any:
    """Return vectors as the rows of a matrix, shape (T, n)."""
    matrix = np.full((len(values), n), np.nan)
    for row, value in zip(matrix, values, strict=True):
        if len(value) == n:
            row[:] = value
    return read_only(matrix)


_COLUMNS: dict[str, Callable[[Sequence[Any], int], Any]] = {
    "Integers": lambda values, _n: read_only(np.array(values, dtype=np.int64)),
    "Vector": lambda values, _n: read_only(np.array(values, dtype=np.float64)),
    "Strings": lambda values, _n: read_only(np.array(values, dtype=np.str_)),
    "Matrix": _rows,
    "tuple[Vector, ...]": lambda values, _n: tuple(np.array(value) for value in values),
}
