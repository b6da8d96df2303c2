"""Where system tests run: in real time alone, the others two at a time (see ``tests/run.py``)."""

import os

import pytest

from support.quiet import MARK, TIMEOUT, in_real_time


def pytest_configure() -> None:
    """Let all that the tests start be known as theirs; two workers are on two domains."""
    os.environ[MARK] = str(os.getpid())
    if "PYTEST_XDIST_WORKER" in os.environ:
        os.environ.pop("ROS_DOMAIN_ID", None)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let tests in real time be tried again where others had the machine (``support.quiet``)."""
    for item in items:
        if isinstance(item, pytest.Function) and item.get_closest_marker("realtime"):
            item.obj = in_real_time(item.obj)
            if not item.get_closest_marker("timeout"):
                item.add_marker(pytest.mark.timeout(TIMEOUT))
