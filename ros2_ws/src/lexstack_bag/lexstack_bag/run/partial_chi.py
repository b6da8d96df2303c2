"""Chi of some robots alone, from one of several solvers, among the joints of all robots.

A bag has the messages of several senders in the order of their arrival, which need not be that of
their ticks: each sender has a stream of its own until all are there.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack_bag.run.columns import StreamBuilder
from lexstack_bag.run.run import ChiStream, Integers, Run, read_only

_VECTORS = ("chi", "lower", "upper")


def robots_of(names: str, team: Team) -> tuple[int, ...]:
    """Return the places of the robots that a row of chi is about; all where it names none."""
    named = set(names.split())
    found = tuple(place for place, name in enumerate(team.names) if name in named)
    return found or tuple(range(len(team.names)))


def among_all(message: Any, team: Team) -> Any:
    """Return a decoded chi with a place for every joint: nan for those that it is not about."""
    robots = robots_of(" ".join(getattr(message, "robots", ())), team)
    if len(robots) == len(team.names):
        return message
    columns = team.columns(robots)
    whole = {}
    for name in _VECTORS:
        values = getattr(message, name)
        if len(values) == columns.size:
            whole[name] = np.full(team.n, np.nan)
            whole[name][columns] = values
    return dataclasses.replace(message, **whole)


class ChiBuilder:
    """Takes the messages of one chi topic, of one sender or of several that share the robots."""

    def __init__(self, team: Team) -> None:
        """Start empty."""
        self._team = team
        self._streams = {"": StreamBuilder(ChiStream, team.n, "last")}  # by sender of parts

    def add(self, message: Any, sent: int) -> None:
        """Append a decoded message that was sent at a time [ns]."""
        whole = among_all(message, self._team)
        sender = "" if whole is message else str(message.sender).partition("@")[0]
        if sender not in self._streams:
            self._streams[sender] = StreamBuilder(ChiStream, self._team.n, "last")
        self._streams[sender].add(whole, sent)

    def begin_anew(self) -> None:
        """Forget the parts: the plant was reset. A stream sees that itself where its ticks do."""
        self._streams = {"": self._streams[""]}

    def build(self) -> tuple[ChiStream, ChiStream]:
        """Return the last message of each tick, and those that these replaced, as they arrived."""
        last, replaced = [], []
        for builder in self._streams.values():
            last.append(builder.build())
            if builder.replaced is not None:
                replaced.append(builder.replaced.build())
        if len(last) == 1:
            return last[0], replaced[0]
        rows = concatenated(last)
        rows = rows_of(rows, np.lexsort((rows.sent, rows.tick)))
        ends = np.append(np.diff(rows.tick) > 0, True)  # the last row of each tick
        before = concatenated([*replaced, rows_of(rows, np.flatnonzero(~ends))])
        return (
            rows_of(rows, np.flatnonzero(ends)),
            rows_of(before, np.argsort(before.sent, kind="stable")),
        )


def concatenated(streams: Sequence[ChiStream]) -> ChiStream:
    """Return the rows of streams, one stream after another."""
    longest = max(stream.slacks.shape[1] for stream in streams)

    def column(name: str) -> NDArray[Any]:
        columns = [getattr(stream, name) for stream in streams]
        if name == "slacks":
            missing = [((0, 0), (0, longest - part.shape[1])) for part in columns]
            columns = [
                np.pad(part, width, constant_values=np.nan)
                for part, width in zip(columns, missing, strict=True)
            ]
        return read_only(np.concatenate(columns))

    return ChiStream(**{field.name: column(field.name) for field in dataclasses.fields(ChiStream)})


def rows_of(stream: ChiStream, rows: Integers) -> ChiStream:
    """Return some rows of a stream, in their order."""
    names = [field.name for field in dataclasses.fields(ChiStream)]
    return ChiStream(**{name: read_only(getattr(stream, name)[rows]) for name in names})


def joined(run: Run, node: str) -> ChiStream:
    """Return the chi of a node tick by tick, joined from all messages of each tick.

    A row is the last message of its tick; joints that this is not about are those of the last
    message before it that is.
    """
    last, before = run.chi[node], run.replaced.get(node)
    if before is None or not len(before.tick) or not len(last.tick):
        return last
    rows = np.minimum(np.searchsorted(last.tick, before.tick), len(last.tick) - 1)
    same = last.tick[rows] == before.tick
    whole: dict[str, NDArray[Any]] = {}
    for name in _VECTORS:
        values, others = getattr(last, name), getattr(before, name)
        row, column = np.nonzero(np.isnan(values[rows]) & ~np.isnan(others) & same[:, None])
        filled = values.copy()
        filled[rows[row], column] = others[row, column]  # of several the last one stays
        whole[name] = read_only(filled)
    return dataclasses.replace(last, **whole)
