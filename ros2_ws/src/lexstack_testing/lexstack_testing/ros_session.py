"""ROS in this process, on a domain that no other run has."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from rclpy.signals import SignalHandlerOptions

from lexstack_bringup.domain import own_domain

_VARIABLE = "ROS_DOMAIN_ID"


@contextmanager
def ros_session() -> Iterator[int]:
    """Yield the domain of this process and of those that it starts meanwhile."""
    before = os.environ.get(_VARIABLE)
    with own_domain() as domain:
        os.environ[_VARIABLE] = str(domain)
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        try:
            yield domain
        finally:
            rclpy.try_shutdown()
            if before is None:
                del os.environ[_VARIABLE]
            else:
                os.environ[_VARIABLE] = before
