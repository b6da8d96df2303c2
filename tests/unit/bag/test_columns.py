"""Messages become columns as they come."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from lexstack_bag.run.columns import StreamBuilder
from lexstack_bag.run.run import Integers, Matrix, Ragged, Strings, Vector


@dataclass(frozen=True)
class Example:
    tick: Integers
    stamp: Vector
    place: Integers
    row: Matrix
    text: Strings
    ragged: Ragged


def message(tick, place, **fields):
    stamp = SimpleNamespace(sec=place, nanosec=500_000_000)
    header = SimpleNamespace(stamp=stamp)
    defaults = {"row": np.full(3, place), "text": f"text {place % 2}", "ragged": np.ones(place % 3)}
    return SimpleNamespace(tick=tick, header=header, place=place, **(defaults | fields))


def built(messages, keep="all"):
    builder = StreamBuilder(Example, 3, keep)
    for entry in messages:
        builder.add(entry)
    return builder.build()


@pytest.mark.parametrize(
    ("ticks", "kept"),
    [
        ([], []),
        ([0, 1, 2], [0, 1, 2]),
        ([5, 5, 5, 6], [0, 3]),  # paused: the same tick is told again
        ([7, 8, 0, 1, 1, 3], [2, 3, 5]),  # reset: what was before it is another run
    ],
)
def test_one_message_per_tick_since_the_last_reset(ticks, kept):
    stream = built([message(tick, i) for i, tick in enumerate(ticks)], "first")
    assert stream.place.tolist() == kept
    assert stream.row[:, 0].tolist() == kept
    assert len(stream.ragged) == len(stream.text) == len(kept)


def test_every_kind_of_column():
    stream = built([message(4, 0), message(4, 1, row=np.zeros(0)), message(2, 2)])
    assert stream.tick.tolist() == [4, 4, 2]
    assert stream.stamp.tolist() == [0.5, 1.5, 2.5]
    np.testing.assert_array_equal(stream.row, [[0, 0, 0], [np.nan] * 3, [2, 2, 2]])
    np.testing.assert_array_equal(stream.ragged, [[np.nan, np.nan], [1, np.nan], [1, 1]])
    assert stream.text.tolist() == ["text 0", "text 1", "text 0"]
    assert (stream.text == "text 0").tolist() == [True, False, True]
    assert stream.text[0] is stream.text[2], "kept once"


@pytest.mark.parametrize("name", ["tick", "stamp", "row", "text", "ragged"])
def test_columns_are_read_only_also_without_messages(name):
    for messages in ([], [message(0, 0)]):
        assert not getattr(built(messages), name).flags.writeable


def test_the_last_message_of_a_tick_where_a_source_answers_twice():
    ticks = [7, 8, 0, 1, 1, 3]
    stream = built([message(tick, i) for i, tick in enumerate(ticks)], "last")
    assert stream.place.tolist() == [2, 4, 5]
    assert built([], "last").place.tolist() == []
