"""Messages as bytes in CDR, as they are on the wire: read and written without their Python objects.

A generated message costs some ten microseconds to make, and as many to check and to convert, at
every reader and every tick. Of the messages that come at every tick nothing changes but numbers:
where each number stands follows from the strings and the lengths of sequences, which stay as they
are for many ticks. So this is worked out once, from the type's own description of its fields
(``get_fields_and_field_types``), and again only where a string or a length has changed.

CDR of ROS 2 (encoding 1, OMG DDS-XTypes 7.4.1): 4 bytes of head, of which the second says the
order of bytes; then all fields one after another, each number aligned to its size, counted from
behind the head. A string is its length with the closing zero (4 bytes), its bytes, and a zero; a
sequence is its length (4 bytes) and its elements; a nested message is its fields.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np
from rclpy.serialization import serialize_message

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
_MOST = 100_000  # numbers, strings and messages of one message


class CdrError(InputError):
    """Bytes that are no message of the type."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    Attributes:
        name: of the field.
        kind: a key of ``_NUMBERS``, or "string"; empty: a nested message.
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
class _Number:
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
        lengths: of every sequence of messages, by path.
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
        self.numbers: list[_Number] = []
        self.texts: dict[str, Any] = {}
        self.lengths: dict[str, int] = {}
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
            if not field.kind:
                self.lengths[path] = count
        if field.kind == "string":
            texts = [self._text() for _ in self._counted(1 if count is None else count)]
            self.texts[path] = texts[0] if count is None else texts
        elif field.kind:
            self._number(path, _NUMBERS[field.kind], count)
        else:
            for i in self._counted(1 if count is None else count):
                for inner in field.fields:
                    self._walk(inner, f"{path}{'' if count is None else f'.{i}'}.{inner.name}")

    def _counted(self, count: int) -> range:
        """Return the places of so many elements; raises CdrError where no message has as many."""
        self._left -= count
        if self._left < 0:
            raise CdrError(f"a length is beyond {_MOST}")
        return range(count)

    def _number(self, path: str, code: str, count: int | None) -> None:
        """Go over numbers. An empty sequence has no alignment of elements."""
        width = struct.calcsize(f"={code}")
        if count != 0:
            self._align(width)
        self.numbers.append(_Number(path, code, self.size, count))
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


class Reader:
    """Reads messages of one type; quickly where strings and lengths are those of the last one."""

    def __init__(self, message_class: type, where: str = "", wanted: Collection[str] = ()) -> None:
        """Read all fields, or those named, at the top alone; ``where``: the topic, for errors."""
        self._where = where or message_class.__name__
        self._fields = fields_of(message_class)
        self._wanted = frozenset(wanted or (field.name for field in self._fields))
        self._layout: Layout | None = None

    def __call__(self, data: bytes) -> SimpleNamespace:
        """Return the values by name, nested as in the message; raises CdrError.

        Strings are str, sequences of strings and of messages lists. Arrays and sequences of numbers
        are read-only arrays (n,), aligned views of a copy of the bytes.
        """
        if self._layout is None or not self._layout.fits(data):
            self._prepare(data)
        body = data[HEAD:]
        found = [*self._texts, *self._singles.unpack_from(body)]
        found += [np.frombuffer(body, kind, count, place) for kind, place, count in self._arrays]
        return self._tree.filled(found)

    def _prepare(self, data: bytes) -> None:
        """Work out the layout of a message, and from it what is to be read at each tick."""
        try:
            layout = Layout(self._fields, data, self._wanted)
        except CdrError as error:
            raise CdrError(f"{self._where}: bytes that are no message: {error}") from error
        numbers = [number for number in layout.numbers if self._wants(number.path)]
        singles = [number for number in numbers if number.count is None]
        arrays = [number for number in numbers if number.count is not None]
        texts = {path: text for path, text in layout.texts.items() if self._wants(path)}
        self._texts = tuple(texts.values())
        self._singles = struct.Struct(layout.order + _packed(singles))
        self._arrays = [
            (np.dtype(_numpy(layout.order, each.code)), each.place, each.count) for each in arrays
        ]
        self._tree = _Tree(
            [*texts, *(each.path for each in (*singles, *arrays))],
            {path: count for path, count in layout.lengths.items() if self._wants(path)},
        )
        self._layout = layout

    def _wants(self, path: str) -> bool:
        """Return whether a path is below a field that is read."""
        return path.partition(".")[0] in self._wanted


def _packed(numbers: Collection[_Number]) -> str:
    """Return the format of ``struct`` in which single numbers stand, with gaps between them."""
    parts, end = [], 0
    for number in numbers:
        parts.append(f"{number.place - end}x{number.code}")
        end = number.place + struct.calcsize(f"={number.code}")
    return "".join(parts)


def _numpy(order: str, code: str) -> str:
    """Return numpy's name of numbers: a byte is one character, and others have other letters."""
    return "S1" if code == "c" else order + code


class _Tree:
    """The shape of a nested message: puts values, in the order of their paths, into its fields."""

    def __init__(self, paths: Sequence[str], lengths: Mapping[str, int]) -> None:
        """Make the shape of ``paths``; ``lengths``: of the sequences of messages among them."""
        places = list(enumerate(path.split(".") for path in paths))
        self._make(places, {tuple(path.split(".")): n for path, n in lengths.items()}, ())

    def _make(
        self,
        places: list[tuple[int, list[str]]],
        lengths: Mapping[tuple[str, ...], int],
        above: tuple[str, ...],
    ) -> None:
        """Make the part of the tree below a path."""
        depth = len(above)
        leaves = [(place, path[-1]) for place, path in places if len(path) == depth + 1]
        self._places = tuple(place for place, _ in leaves)
        self._names = tuple(name for _, name in leaves)
        inner = [path[depth] for _, path in places if len(path) > depth + 1]
        inner += [path[depth] for path in lengths if path[:depth] == above and len(path) > depth]
        self._list = above in lengths or (
            not leaves and all(map(str.isdigit, inner)) and inner != []
        )
        self._inner: dict[str, _Tree] = {}
        for name in dict.fromkeys(inner):
            below = [(p, path) for p, path in places if path[depth] == name]
            self._inner[name] = tree = _Tree.__new__(_Tree)
            tree._make(below, lengths, (*above, name))

    def filled(self, values: Sequence[Any]) -> Any:
        """Return values in this shape: namespaces, and lists of them."""
        if self._list:
            return [tree.filled(values) for tree in self._inner.values()]
        result = SimpleNamespace()
        fields = result.__dict__
        for name, place in zip(self._names, self._places, strict=True):
            fields[name] = values[place]
        for name, tree in self._inner.items():
            fields[name] = tree.filled(values)
        return result


class Buffer:
    """The bytes of a message of which numbers change, and strings and lengths stay."""

    def __init__(self, message: Any) -> None:
        """Serialise a generated message once."""
        data = serialize_message(message)
        layout = Layout(fields_of(type(message)), data)
        data = data[: HEAD + layout.size]  # the generated type may estimate too much, and leave it
        # With four bytes before the head the content is aligned as numpy would have it.
        whole = memoryview(bytearray(HEAD + len(data)))
        self._data, self._body = whole[HEAD:], whole[2 * HEAD :]
        self._data[:] = data
        self._views: dict[str, Any] = {}
        self._singles: dict[str, tuple[Any, int]] = {}
        for number in layout.numbers:
            if number.count is None:
                single = struct.Struct(layout.order + number.code)
                self._singles[number.path] = single.pack_into, number.place
            else:
                kind = _numpy(layout.order, number.code)
                at = number.count, number.place
                self._views[number.path] = np.frombuffer(self._body, kind, *at)

    def put(self, path: str, value: Any) -> None:
        """Write a number; raises KeyError for another path, struct.error for another type."""
        pack_into, place = self._singles[path]
        pack_into(self._body, place, value)

    def put_all(self, path: str, values: Any) -> None:
        """Write an array of numbers; raises KeyError, or ValueError where the length differs."""
        view = self._views[path]
        if len(view) != len(values):
            raise ValueError(f"{path}: {len(values)} numbers in place of {len(view)}")
        view[:] = values

    @property
    def data(self) -> bytes:
        """The message."""
        return bytes(self._data)
