"""ROS in this process, on a domain that no other run has."""

from __future__ import annotations

import gc
import itertools
import os
from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from lexstack_bringup.domain import own_domain

_VARIABLE = "ROS_DOMAIN_ID"
_FIRST, _COUNT = 51, 50
_sessions = itertools.count(os.getpid())


@contextmanager
def ros_session(*, children: bool) -> Iterator[Context]:
    """Yield a context on a domain of its own; several may be there at the same time.

    A node lives in DDS until it is destroyed or collected, which may be after its session: what it
    has latched would be heard by the next run on its domain. So the sessions of a process take one
    number after another, and none of those that runs try first.

    With ``children`` the processes that are started meanwhile get the domain by their environment.
    """
    before = os.environ.get(_VARIABLE)
    start = next(_sessions)
    with own_domain([_FIRST + (start + k) % _COUNT for k in range(_COUNT)]) as domain:
        context = Context()
        rclpy.init(
            context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )
        if children:
            os.environ[_VARIABLE] = str(domain)
        try:
            yield context
        finally:
            rclpy.try_shutdown(context=context)
            gc.collect()
            if children and before is None:
                del os.environ[_VARIABLE]
