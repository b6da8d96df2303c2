"""Tests with the mark ``realtime`` need the machine to themselves: see ``support.quiet``."""

import os

import pytest

from support.quiet import MARK, TIMEOUT, in_real_time


def pytest_configure() -> None:
    """Let all that the tests start be known as theirs."""
    os.environ[MARK] = str(os.getpid())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let each such test be tried again where others had the machine."""
    for item in items:
        if isinstance(item, pytest.Function) and item.get_closest_marker("realtime"):
            item.obj = in_real_time(item.obj)
            if not item.get_closest_marker("timeout"):
                item.add_marker(pytest.mark.timeout(TIMEOUT))
