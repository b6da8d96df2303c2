"""Waiting with a deadline, for a condition, a service's answer or listeners, all in one place."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any

from rclpy.duration import Duration
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher

from lexstack.errors import LexstackError

_STEP = 0.05  # s of wall time between two looks where nothing comes
# s of wall time in which a server comes to know a client that knows it already. A server that
# hears a request first drops the answer after 0.1 s: the middleware matches the two topics of a
# service one by one, and a client sees its own half alone.
_KNOWN = 0.3


class NoAnswerError(LexstackError):
    """A service did not answer in time; the text names it."""


def wait_until(
    executor: Executor,
    condition: Callable[[], Any],
    seconds: float,
    watch: Callable[[], Any] = lambda: None,
) -> bool:
    """Return whether a condition came true in time.

    Args:
        executor: works meanwhile.
        condition: looked at after everything that the executor does.
        seconds: of wall time.
        watch: called as often; may raise, where waiting has no sense any more.
    """
    end = time.monotonic() + seconds
    while not condition():
        left = end - time.monotonic()
        if left < 0.0:
            return False
        executor.spin_once(timeout_sec=min(_STEP, left))
        watch()
    return True


def lasting(condition: Callable[[], bool], seconds: float) -> Callable[[], bool]:
    """Return whether a condition has held at every look for some time [s], as a condition."""
    since = [time.monotonic()]

    def lasts() -> bool:
        now = time.monotonic()
        if not condition():
            since[0] = now
        return now - since[0] >= seconds

    return lasts


def not_taken(publishers: Iterable[Publisher], seconds: float) -> list[str]:
    """Return the topics of which some listener has not got all that was sent, after a while.

    With a node that ends, what is on its way is lost. An acknowledgement may take as long as the
    middleware's heartbeat, 3 s; a listener that died gives none, so this waits ``seconds`` in all.
    """
    end = time.monotonic() + seconds
    return [
        publisher.topic_name
        for publisher in publishers
        if not publisher.wait_for_all_acked(Duration(seconds=max(end - time.monotonic(), 0.0)))
    ]


def answer_of(
    executor: Executor,
    client: Any,
    request: Any,
    seconds: float,
    watch: Callable[[], Any] = lambda: None,
) -> Any:
    """Return a service's answer; raises NoAnswerError where none comes in ``seconds``.

    ``watch`` is that of ``wait_until``.
    """
    future = client.call_async(request)
    if not wait_until(executor, future.done, seconds, watch):
        client.remove_pending_request(future)
        raise NoAnswerError(f"{client.service_name}: no answer in {seconds:g} s")
    return future.result()


def let_be_known(executor: Executor, watch: Callable[[], Any] = lambda: None) -> None:
    """Give servers the time to know clients that see them; ``watch`` is that of ``wait_until``."""
    wait_until(executor, lambda: False, _KNOWN, watch)


def call(
    node: Node,
    executor: Executor,
    kind: Any,
    name: str,
    request: Any,
    seconds: float,
    *,
    watch: Callable[[], Any] = lambda: None,
) -> Any:
    """Return a service's answer to a client of this one call.

    Args:
        node: of the client; the executor's.
        executor: works meanwhile.
        kind: of the service.
        name: of the service.
        request: to it.
        seconds: of wall time for the service to be there, and as long for the answer.
        watch: that of ``wait_until``.

    Raises:
        NoAnswerError: nobody serves the name, or no answer comes.
    """
    client = node.create_client(kind, name)
    try:
        if not wait_until(executor, client.service_is_ready, seconds, watch):
            raise NoAnswerError(f"{name}: nobody serves it within {seconds:g} s")
        let_be_known(executor, watch)
        return answer_of(executor, client, request, seconds, watch)
    finally:
        node.destroy_client(client)
