"""The library's registries in tests: what a test adds to them is gone after it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from lexstack.hqp import SOLVERS
from lexstack.tasks import TASKS
from lexstack.transition import METHODS


@pytest.fixture
def registries() -> Iterator[None]:
    """Take out again what a test registers, but for what our own packages bring."""
    before = [(known, set(known)) for known in (METHODS, SOLVERS, TASKS)]
    yield
    for known, names in before:
        for name in known.keys() - names:
            if not known[name].__module__.startswith("lexstack"):
                del known[name]
