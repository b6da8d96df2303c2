"""Messages that wait: taken with the one that the executor hands over, so that none stays behind.

The executor takes one message for each that it was told of. Where it was told of too few, as
happens on a machine that is much too busy, as many stay in the queue for good, and every message
is then taken too late by that many.
"""

from __future__ import annotations

from typing import Any

from rclpy.subscription import Subscription

_MOST = 1000  # messages that are taken at once


def waiting(subscription: Subscription) -> list[tuple[Any, dict[str, int]]]:
    """Return the messages that wait, each with its info, in their order; raw ones as bytes."""
    found, handle = [], subscription.handle
    with handle:
        for _ in range(_MOST):
            try:
                item = handle.take_message(subscription.msg_type, subscription.raw)
            except RuntimeError:
                continue  # bytes that are no message
            if item is None:
                break
            found.append(item)
    return found
