"""The solver's chi as bytes: of each stack's messages nothing but numbers changes, as a rule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lexstack.types import Vector
from lexstack_interfaces.msg import Chi
from lexstack_ros.messages.cdr import Buffer
from lexstack_ros.messages.conversions import WORLD, to_array, to_time

_KEPT = 16  # buffers: of stacks whose messages take turns


class SolutionBytes:
    """Makes the messages of one sender."""

    def __init__(self, sender: str) -> None:
        """``sender`` names this process."""
        self._sender = sender
        self._buffers: dict[tuple[object, ...], Buffer] = {}

    def __call__(
        self,
        stamp: float,
        robots: Sequence[str],
        words: Mapping[str, str],
        vectors: Mapping[str, Vector],
        numbers: Mapping[str, Any],
    ) -> bytes:
        """Return the message of a state's time [s].

        Args:
            stamp: that of the state.
            robots: names, in the order in which the vectors stack them.
            words: the fields stack and reason.
            vectors: the fields of numbers in a row.
            numbers: all other fields but the transitions, which a solver does not tell.
        """
        key = (*robots, *words.values(), *(vector.size for vector in vectors.values()))
        buffer = self._buffers.get(key)
        if buffer is None:
            message = Chi(sender=self._sender, robots=list(robots), **words)
            message.header.frame_id = WORLD
            for name, vector in vectors.items():
                setattr(message, name, to_array(vector))
            if len(self._buffers) >= _KEPT:
                self._buffers.clear()
            buffer = self._buffers[key] = Buffer(message)
        time = to_time(stamp)
        buffer.put("header.stamp.sec", time.sec)
        buffer.put("header.stamp.nanosec", time.nanosec)
        for name, number in numbers.items():
            buffer.put(name, number)
        for name, vector in vectors.items():
            buffer.put_all(name, vector)
        return buffer.data
