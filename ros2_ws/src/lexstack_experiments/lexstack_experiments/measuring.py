"""What experiments and benches measure alike."""

from __future__ import annotations

import gc
import os
import sys
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


def paired_ratio(ours: ArrayLike, others: ArrayLike, percent: float = 50.0) -> float:
    """Return ours over theirs where both took turns: the median over the turns.

    Args:
        ours: times, one row per turn.
        others: likewise, as many turns; a turn may have another number of times.
        percent: which percentile of a turn is compared.
    """
    mine, theirs = np.asarray(ours, dtype=float), np.asarray(others, dtype=float)
    if mine.ndim != 2 or theirs.ndim != 2 or len(mine) != len(theirs):
        raise ValueError(f"turns do not pair: {mine.shape} and {theirs.shape}")
    return float(
        np.median(np.percentile(mine, percent, axis=1) / np.percentile(theirs, percent, axis=1))
    )


@contextmanager
def silent() -> Iterator[None]:
    """Send all that is printed meanwhile, by compiled libraries too, to nowhere."""
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    kept = [os.dup(place) for place in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for place in (1, 2):
            os.dup2(nowhere, place)
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for place, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, place)
            os.close(copy)
        os.close(nowhere)
