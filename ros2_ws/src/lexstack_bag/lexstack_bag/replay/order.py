"""The order in which a lockstep run happened, where a bag has another one.

The recorder hears every topic by itself: under load it may write an answer to a tick behind the
next state, though that was sent only after the answer had come, or before the state that it
answers. A live node would wait in vain, or miss the answer to the state at hand.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from lexstack_bag.run.columns import seconds
from lexstack_bag.storage.container import RawMessage
from lexstack_bag.topics import PLAN, PLANT_STATE, SOLUTION

ANSWERS = (SOLUTION, PLAN)
"""What the controller waits for, with the stamp of the state that it answers."""

Entry = tuple[RawMessage, float]  # a message, and the stamp [s] of a state or an answer

_AHEAD = 300  # messages, some tenths of a second


def in_lockstep(
    messages: Iterable[RawMessage], decode: Callable[[RawMessage], Any]
) -> Iterator[RawMessage]:
    """Yield all messages, every answer between its state and the next; ``decode`` reads them."""
    early: list[Entry] = []  # whose states are still to come
    now = float("-inf")
    for message, stamp in _none_late(messages, decode):
        if message.topic in ANSWERS and stamp > now:
            early.append((message, stamp))
            continue
        yield message
        if message.topic == PLANT_STATE:
            now = stamp
            yield from (answer for answer, due in early if due <= now)
            early = [entry for entry in early if entry[1] > now]
    yield from (answer for answer, _ in early)


def _none_late(
    messages: Iterable[RawMessage], decode: Callable[[RawMessage], Any]
) -> Iterator[Entry]:
    """Yield all messages with their stamps, every answer to a state before the next state."""
    waiting: deque[Entry] = deque()
    for message in messages:
        read = message.topic in ANSWERS or message.topic == PLANT_STATE
        waiting.append((message, seconds(decode(message).header.stamp) if read else 0.0))
        if len(waiting) > _AHEAD:
            yield from _next(waiting)
    while waiting:
        yield from _next(waiting)


def _next(waiting: deque[Entry]) -> Iterator[Entry]:
    """Take the first message out, and before a state the answers to those before it."""
    first, stamp = waiting.popleft()
    if first.topic == PLANT_STATE:
        late = [entry for entry in waiting if entry[0].topic in ANSWERS and entry[1] < stamp]
        for entry in late:
            waiting.remove(entry)
            yield entry
    yield first, stamp
