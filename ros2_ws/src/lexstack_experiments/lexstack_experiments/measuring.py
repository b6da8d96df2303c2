"""What experiments and benches measure alike."""

from __future__ import annotations

import gc
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike


@contextmanager
def no_collection() -> Iterator[None]:
    """Keep the garbage collector from running in between."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def largest(values: Iterable[float | None]) -> float | None:
    """Return the largest of the known values, None without any."""
    return max((value for value in values if value is not None), default=None)


def after_last(marks: ArrayLike) -> int:
    """Return the place behind the last mark, 0 without any."""
    places = np.flatnonzero(marks)
    return int(places[-1]) + 1 if places.size else 0


def p50_p99(times: ArrayLike) -> tuple[float, float]:
    """Return the median and the 99th percentile."""
    p50, p99 = np.percentile(times, (50.0, 99.0))
    return float(p50), float(p99)
