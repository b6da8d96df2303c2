"""Where the fields of a message stand in its bytes, from the description that its type gives.

CDR of ROS 2 (encoding 1, OMG DDS-XTypes 7.4.1): 4 bytes of head, of which the second says the
order of bytes; then all fields one after another, each number aligned to its size, counted from
behind the head. A string is its length with the closing zero (4 bytes), its bytes, and a zero; a
sequence is its length (4 bytes) and its elements; a nested message is its fields.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

from lexstack.errors import InputError

HEAD = 4
"""Bytes before the content."""

_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}
_NUMBERS = {
    "boolean": "?",
    "octet": "c",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float": "f",
    "double": "d",
}
_LENGTH = struct.calcsize("<I")
_MOST = 100_000  # fields, strings and messages of one message: so no walk takes long


class CdrError(InputError):
    """Bytes that are no message of the type."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    Attributes:
        name: of the field.
        kind: of numbers a key of ``_NUMBERS``, or "string"; empty: a nested message.
        fields: of the nested message.
        count: elements of an array of fixed length; -1: a sequence; None: a single value.
    """

    name: str
    kind: str
    fields: tuple[Field, ...] = ()
    count: int | None = None


@cache
def fields_of(message_class: type) -> tuple[Field, ...]:
    """Return the fields of a generated message class in their order.

    Raises:
        TypeError: a field is of a type that is not supported: wide characters and their strings.
    """
    described = message_class.get_fields_and_field_types()  # type: ignore[attr-defined]
    return tuple(_field(name, text) for name, text in described.items())


def _field(name: str, text: str) -> Field:
    """Return a field from its description: double, sequence<string, 4>, pkg/Type[3], string<9>."""
    sequence = re.fullmatch(r"sequence<(.+?)(?:, \d+)?>", text)
    fixed = re.fullmatch(r"(.+)\[(\d+)\]", text)
    kind, count = text, None
    if sequence:
        kind, count = sequence[1], -1
    elif fixed:
        kind, count = fixed[1], int(fixed[2])
    kind = re.sub(r"^string<\d+>?$", "string", kind)
    if kind == "string" or kind in _NUMBERS:
        return Field(name, kind, count=count)
    package, slash, type_name = kind.partition("/")
    if not slash:
        raise TypeError(f"{name}: {text} is not supported")
    return Field(name, "", fields_of(getattr(import_module(f"{package}.msg"), type_name)), count)


@dataclass(frozen=True, slots=True)
class Number:
    """Numbers of one type in a row: where they are behind the head.

    Attributes:
        path: the field's, "header.stamp.sec", "transitions.0.alpha".
        code: of ``struct`` and numpy, without the order of bytes.
        place: of the first byte behind the head.
        count: how many; None: a single one.
    """

    path: str
    code: str
    place: int
    count: int | None


class Layout:
    """Where everything stands in a message of given strings and lengths.

    Attributes:
        order: of bytes, "<" or ">".
        numbers: all numbers, in their order.
        texts: all strings by path; a sequence of strings as a list.
        arrays: paths of all sequences and arrays of messages.
        size: bytes up to the end of the last field, without the head.
    """

    def __init__(
        self, fields: tuple[Field, ...], data: bytes, wanted: Collection[str] = ()
    ) -> None:
        """Walk over a message; raises CdrError.

        ``wanted`` names fields at the top; the walk ends behind the last of them. Without any it
        goes to the end.
        """
        order = _ORDERS.get(bytes(data[:2]))
        if order is None or len(data) < HEAD:
            raise CdrError(f"head {bytes(data[:HEAD]).hex()!r} is not that of CDR")
        self.order = order
        self.numbers: list[Number] = []
        self.texts: dict[str, Any] = {}
        self.arrays: list[str] = []
        self.size = 0
        self._body = memoryview(data)[HEAD:]
        self._known: list[tuple[int, int]] = []  # bytes that decide where the rest stands
        self._left = _MOST
        rest = set(wanted)
        for field in fields:
            self._walk(field, field.name)
            rest.discard(field.name)
            if wanted and not rest:
                break
        self._ranges = tuple(
            (first, last, bytes(data[first:last])) for first, last in self._joined()
        )
        del self._body

    def fits(self, data: bytes) -> bool:
        """Return whether another message has the same strings and lengths."""
        fit = len(data) >= HEAD + self.size
        for first, last, known in self._ranges:  # `all` would take three times as long
            fit = fit and data[first:last] == known
        return fit

    def _joined(self) -> Iterator[tuple[int, int]]:
        """Yield the ranges of bytes that decide, the head first, neighbours joined.

        Padding is in none: generated types leave in it whatever was in the memory.
        """
        begin, end = 0, 2
        for first, last in self._known:
            if first + HEAD > end:
                yield begin, end
                begin = first + HEAD
            end = last + HEAD
        yield begin, end

    # ---- the walk

    def _walk(self, field: Field, path: str) -> None:
        """Go over one field."""
        count = field.count
        if count == -1:
            count = self._length()
        if count is not None and not field.kind:
            self.arrays.append(path)
        if field.kind == "string":
            texts = [self._text() for _ in self._counted(1 if count is None else count)]
            self.texts[path] = texts[0] if count is None else texts
        elif field.kind:
            self._counted(1)
            self._number(path, _NUMBERS[field.kind], count)
        else:
            for i in self._counted(1 if count is None else count):
                for inner in field.fields:
                    self._walk(inner, f"{path}{'' if count is None else f'.{i}'}.{inner.name}")

    def _counted(self, count: int) -> range:
        """Return the places of so many elements; raises CdrError where no message has as many."""
        self._left -= count
        if self._left < 0:
            raise CdrError(f"more than {_MOST} fields, strings and messages")
        return range(count)

    def _number(self, path: str, code: str, count: int | None) -> None:
        """Go over numbers. An empty sequence has no alignment of elements."""
        width = struct.calcsize(f"={code}")
        if count != 0:
            self._align(width)
        self.numbers.append(Number(path, code, self.size, count))
        self._advance(width * (1 if count is None else count))

    def _length(self) -> int:
        """Go over a length and return it."""
        self._align(_LENGTH)
        begin = self.size
        self._advance(_LENGTH)
        self._known.append((begin, self.size))
        return int(struct.unpack_from(f"{self.order}I", self._body, begin)[0])

    def _text(self) -> str:
        """Go over a string and return it."""
        length = self._length()
        begin = self.size
        self._advance(length)
        self._known.append((begin, self.size))
        try:
            return bytes(self._body[begin : self.size - 1 if length else begin]).decode()
        except UnicodeDecodeError as error:
            raise CdrError(f"a string is not UTF-8: {error}") from error

    def _align(self, width: int) -> None:
        """Go to the next multiple of a width."""
        self.size += -self.size % width

    def _advance(self, count: int) -> None:
        """Go over bytes; raises CdrError where there are none."""
        self.size += count
        if self.size > len(self._body):
            raise CdrError(f"ends after {len(self._body)} bytes, {self.size} are needed")
