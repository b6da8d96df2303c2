"""From decoded messages to the arrays of a stream, one array per field, as the messages come.

A message is taken apart at once: an hour of a run is a few hundred megabytes of numbers, and
would be some gigabytes of messages.
"""

from __future__ import annotations

import dataclasses
from array import array
from collections.abc import Callable
from typing import Any, Generic, Literal, Protocol, TypeVar

import numpy as np

from lexstack_bag.run.run import (
    POSITIONS,
    ChiStream,
    PlanStream,
    PlantStream,
    ProgressStream,
    TransitionStream,
    read_only,
)

T = TypeVar("T", PlantStream, ChiStream, TransitionStream, PlanStream, ProgressStream)

Keep = Literal["first", "last", "all"]

_SINCE: dict[str, Any] = {"robots": (), "references": 0}
"""Fields that messages of older bags do not have, and what stands for them."""


class _Column(Protocol):
    """One field of all messages."""

    def add(self, value: Any) -> None:
        """Append the value of one more message."""
        ...

    def build(self) -> Any:
        """Return the whole as a read-only array with one row per message."""
        ...


class StreamBuilder(Generic[T]):
    """Takes the messages of one topic whose fields bear the names of the stream's fields.

    Attributes:
        replaced: takes the messages that another one of the same tick has replaced; None where
            that cannot be.
    """

    def __init__(self, kind: type[T], n: int, keep: Keep, nq: int | None = None) -> None:
        """Start empty.

        Args:
            kind: the stream's class; its annotations say how each column is made.
            n: length of chi; a vector of another length (a failed solve has none) becomes nan.
            keep: which messages of a tick. Unless all, begin anew where the ticks do: at a reset
                of the plant. A paused plant tells a tick again; a source answers again when it is
                asked for another stack.
            nq: length of q and q*; None: that of chi.
        """
        self._kind = kind
        self._n = n
        self._lengths = dict.fromkeys(POSITIONS, n if nq is None else nq)
        self._keep = keep
        self.replaced: StreamBuilder[T] | None = None
        if keep == "last":
            self.replaced = StreamBuilder(kind, n, "all", nq)
        self._restart()

    def add(self, message: Any, sent: int = 0) -> bool:
        """Append a message that was sent at a time [ns]; return whether the ticks began anew."""
        tick = message.tick
        anew = self._keep != "all" and tick < self._last
        if anew:
            self._restart()
            if self.replaced is not None:
                self.replaced = StreamBuilder(self._kind, self._n, "all", self._lengths["q"])
        if self._keep == "last":
            if tick == self._last and self._waiting is not None and self.replaced is not None:
                self.replaced.add(*self._waiting)
            elif tick != self._last:
                self._append_waiting()
            self._waiting = message, sent
        elif self._keep == "all" or tick != self._last:
            self._append(message, sent)
        self._last = tick
        return anew

    def build(self) -> T:
        """Return the stream; take no more messages."""
        self._append_waiting()
        return self._kind(**{name: column.build() for name, column in self._columns.items()})

    def _append_waiting(self) -> None:
        """Append the message that another one of its tick might have replaced."""
        if self._waiting is not None:
            self._append(*self._waiting)
            self._waiting = None

    def _append(self, message: Any, sent: int) -> None:
        """Append a message to the columns."""
        for name, column in self._columns.items():
            if name == "stamp":
                column.add(seconds(message.header.stamp))
            else:
                column.add(sent if name == "sent" else getattr(message, name, _SINCE.get(name)))

    def _restart(self) -> None:
        """Forget all."""
        self._last = -1
        self._waiting: tuple[Any, int] | None = None
        self._columns = {
            field.name: _COLUMNS[str(field.type)](self._lengths.get(field.name, self._n))
            for field in dataclasses.fields(self._kind)
        }


def seconds(stamp: Any) -> float:
    """Return a ROS time in seconds."""
    return float(stamp.sec + 1e-9 * stamp.nanosec)


class _Numbers:
    """Scalars."""

    def __init__(self, code: str) -> None:
        """Start empty; ``code`` is the type's in ``array``."""
        self._values: array[Any] = array(code)
        self.add = self._values.append

    def build(self) -> Any:
        """Return shape (T,)."""
        return read_only(np.frombuffer(self._values, dtype=self._values.typecode))


class _Rows:
    """Vectors of one length, shape (T, n)."""

    def __init__(self, n: int, code: str = "d") -> None:
        """Start empty; ``code`` is the numbers' type in ``array``."""
        self._n = n
        self._nan = np.full(n, np.nan, dtype=code).tobytes()
        self._values: array[float] = array(code)

    def add(self, value: Any) -> None:
        """Append a vector; one of another length becomes nan."""
        fits = len(value) == self._n
        code = self._values.typecode
        self._values.frombytes(np.asarray(value, code).tobytes() if fits else self._nan)

    def build(self) -> Any:
        """Return shape (T, n)."""
        rows = np.frombuffer(self._values, dtype=self._values.typecode)
        return read_only(rows.reshape(-1, self._n))


class _Ragged:
    """Vectors of different lengths, as rows with nan at their ends."""

    def __init__(self) -> None:
        """Start empty."""
        self._values = array("d")
        self._lengths = array("i")

    def add(self, value: Any) -> None:
        """Append a vector."""
        self._values.frombytes(np.asarray(value, np.float64).tobytes())
        self._lengths.append(len(value))

    def build(self) -> Any:
        """Return shape (T, L), L the longest vector's length."""
        lengths = np.frombuffer(self._lengths, dtype=np.int32)
        longest = int(lengths.max(initial=0))
        rows = np.full((len(lengths), longest), np.nan)
        rows[np.arange(longest) < lengths[:, None]] = np.frombuffer(self._values, dtype=np.float64)
        return read_only(rows)


class _Texts:
    """Texts, each different one kept once."""

    def __init__(self) -> None:
        """Start empty."""
        self._known: dict[str, int] = {}
        self._codes = array("l")

    def add(self, value: str) -> None:
        """Append a text."""
        self._codes.append(self._known.setdefault(value, len(self._known)))

    def build(self) -> Any:
        """Return shape (T,), references to the texts."""
        texts = np.array([*self._known, ""], dtype=object)  # never empty: an index needs one
        return read_only(texts[np.frombuffer(self._codes, dtype=np.int64)])


class _Names(_Texts):
    """Lists of names, with a space between them."""

    def add(self, value: list[str]) -> None:  # type: ignore[override]
        """Append a list."""
        super().add(" ".join(value))


_COLUMNS: dict[str, Callable[[int], _Column]] = {
    "Integers": lambda _n: _Numbers("q"),
    "Vector": lambda _n: _Numbers("d"),
    "Strings": lambda _n: _Texts(),
    "Names": lambda _n: _Names(),
    "Matrix": _Rows,
    "Single": lambda n: _Rows(n, "f"),
    "Ragged": lambda _n: _Ragged(),
}
