"""Messages as bytes, as they are on the wire: read and written without their Python objects.

A generated message costs ten microseconds to make, and more to fill, to check and to convert, at
every reader and every tick. Of the messages that come at every tick nothing changes but numbers:
where each number stands follows from the strings and the lengths of sequences, which stay as they
are for many ticks. So this is worked out once (``cdr_layout``), and again only where a string or a
length has changed.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from rclpy.serialization import serialize_message

from lexstack_ros.messages.cdr_layout import HEAD, CdrError, Layout, Number, fields_of

_KEPT = 8  # layouts: of several stacks, channels or plans, whose messages take turns


class Reader:
    """Reads messages of one type; quickly where strings and lengths are those of an earlier one."""

    def __init__(self, message_class: type, where: str = "", wanted: Collection[str] = ()) -> None:
        """Read all fields, or those named, at the top alone; ``where``: the topic, for errors."""
        self._where = where or message_class.__name__
        self._fields = fields_of(message_class)
        self._wanted = frozenset(wanted or (field.name for field in self._fields))
        self._known: list[_Shape] = []  # the last one that fitted first

    def __call__(self, data: bytes) -> Any:
        """Return the values by name, nested as in the message; raises CdrError.

        Strings are str, sequences of strings and of messages lists. Arrays and sequences of numbers
        are read-only arrays (n,), aligned views of a copy of the bytes.
        """
        for place, shape in enumerate(self._known):
            if shape.layout.fits(data):
                if place:
                    self._known.insert(0, self._known.pop(place))
                return shape.read(data)
        try:
            shape = _Shape(Layout(self._fields, data, self._wanted), self._wanted)
        except CdrError as error:
            raise CdrError(f"{self._where}: bytes that are no message: {error}") from error
        self._known = [shape, *self._known[: _KEPT - 1]]
        return shape.read(data)


class _Shape:
    """What is to be read of messages with the same strings and lengths."""

    def __init__(self, layout: Layout, wanted: Collection[str]) -> None:
        """Take what stands below the ``wanted`` fields of a layout."""

        def wants(path: str) -> bool:
            return path.partition(".")[0] in wanted

        self.layout = layout
        numbers = [number for number in layout.numbers if wants(number.path)]
        singles = [number for number in numbers if number.count is None]
        arrays = [number for number in numbers if number.count is not None]
        texts = {path: text for path, text in layout.texts.items() if wants(path)}
        self._texts = tuple(texts.values())
        self._singles = struct.Struct(layout.order + _packed(singles))
        self._arrays = [(np.dtype(_numpy(layout, each)), each.count, each.place) for each in arrays]
        paths = [*texts, *(each.path for each in (*singles, *arrays))]
        self._tree = _Tree(
            list(enumerate(path.split(".") for path in paths)),
            [path.split(".") for path in layout.arrays if wants(path)],
        )

    def read(self, data: bytes) -> Any:
        """Return the values of a message that fits the layout."""
        body = data[HEAD:]
        found = [*self._texts, *self._singles.unpack_from(body)]
        found += [np.frombuffer(body, *array) for array in self._arrays]
        return self._tree.filled(found)


def _packed(numbers: Collection[Number]) -> str:
    """Return the format of ``struct`` in which single numbers stand, with gaps between them."""
    parts, end = [], 0
    for number in numbers:
        parts.append(f"{number.place - end}x{number.code}")
        end = number.place + struct.calcsize(f"={number.code}")
    return "".join(parts)


def _numpy(layout: Layout, number: Number) -> str:
    """Return numpy's name of numbers: a byte is one character, and others have other letters."""
    return "S1" if number.code == "c" else layout.order + number.code


class _Tree:
    """The shape of a nested message: puts values, in the order of their paths, into its fields."""

    def __init__(
        self,
        places: Collection[tuple[int, list[str]]],
        arrays: Collection[list[str]],
        depth: int = 0,
    ) -> None:
        """Make the part of the tree below a path.

        Args:
            places: of each value below it, its place among all values and its whole path.
            arrays: paths of the arrays of messages there and below, empty ones too.
            depth: words of the path.
        """
        self._list = any(len(path) == depth for path in arrays)
        self._leaves = tuple((path[-1], k) for k, path in places if len(path) == depth + 1)
        # Sorted in one go: a search for each name would be quadratic in the length of an array.
        inner: dict[str, tuple[list[tuple[int, list[str]]], list[list[str]]]] = {}
        for each in places:
            if len(each[1]) > depth + 1:
                inner.setdefault(each[1][depth], ([], []))[0].append(each)
        for path in arrays:
            if len(path) > depth:
                inner.setdefault(path[depth], ([], []))[1].append(path)
        names = sorted(inner, key=int) if self._list else inner
        self._inner = tuple((name, _Tree(*inner[name], depth + 1)) for name in names)

    def filled(self, values: Sequence[Any]) -> Any:
        """Return values in this shape: namespaces, and lists of them."""
        if self._list:
            return [tree.filled(values) for _, tree in self._inner]
        result = SimpleNamespace()
        fields = result.__dict__
        for name, place in self._leaves:
            fields[name] = values[place]
        for name, tree in self._inner:
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
                kind = _numpy(layout, number)
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
