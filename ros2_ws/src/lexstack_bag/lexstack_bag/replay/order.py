"""The order in which a lockstep run happened, where a bag has another one.

The recorder hears every topic by itself: under load it may write an answer to a tick behind the
next state, though that was sent only after the answer had come. A live node would wait in vain.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from lexstack_bag.columns import seconds
from lexstack_bag.container import RawMessage
from lexstack_bag.planning import PLAN
from lexstack_bag.reader import PLANT_STATE

ANSWERS = ("/robot_b/chi", PLAN)
"""What robot A waits for, with the stamp of the state that it answers."""

_AHEAD = 300  # messages, some tenths of a second


def in_lockstep(
    messages: Iterable[RawMessage], decode: Callable[[RawMessage], Any]
) -> Iterator[RawMessage]:
    """Yield all messages, every answer to a state before the next state; ``decode`` reads them."""
    waiting: deque[tuple[RawMessage, float | None]] = deque()
    for message in messages:
        read = message.topic in ANSWERS or message.topic == PLANT_STATE
        stamp = seconds(decode(message).header.stamp) if read else None
        waiting.append((message, stamp))
        if len(waiting) > _AHEAD:
            yield from _next(waiting)
    while waiting:
        yield from _next(waiting)


def _next(waiting: deque[tuple[RawMessage, float | None]]) -> Iterator[RawMessage]:
    """Take the first message out, and before a state the answers to those before it."""
    first, stamp = waiting.popleft()
    if first.topic == PLANT_STATE and stamp is not None:
        late = [
            entry
            for entry in waiting
            if entry[0].topic in ANSWERS and entry[1] is not None and entry[1] < stamp
        ]
        for entry in late:
            waiting.remove(entry)
            yield entry[0]
    yield first
