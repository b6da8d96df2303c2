"""ROS in this process, on a domain that no other run has."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from lexstack_bringup.domain import own_domain

_VARIABLE = "ROS_DOMAIN_ID"


@contextmanager
def ros_session(*, children: bool) -> Iterator[Context]:
    """Yield a context on a domain of its own; several may be there at the same time.

    With ``children`` the processes that are started meanwhile get the domain by their environment.
    """
    before = os.environ.get(_VARIABLE)
    with own_domain() as domain:
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
            if children and before is None:
                del os.environ[_VARIABLE]
