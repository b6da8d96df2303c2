"""Waiting with a deadline, for a condition or for a service's answer, while an executor works."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.executors import Executor

from lexstack.errors import LexstackError

_STEP = 0.05  # s of wall time between two looks where nothing comes


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
        if time.monotonic() > end:
            return False
        executor.spin_once(timeout_sec=_STEP)
        watch()
    return True


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
        raise NoAnswerError(f"{client.srv_name}: no answer in {seconds:g} s")
    return future.result()
