"""Hierarchies of small integers, times powers of two: whatever is exact in them stays exact."""

import numpy as np

from lexstack.hqp import HqpProblem
from lexstack.limits import Bounds
from lexstack.types import LinearTask

SCALES = ("one", "levels", "rows", "weights", "dense")


def integer_problem(rng, scales, n, sizes, soft=0.4):
    """Return a problem of ``n`` joints and levels of ``sizes`` rows, often degenerate.

    Args:
        rng: of everything random in it.
        scales: ``one``: none; ``levels``: 2^-20 to 2^20 for each level; ``rows``: for each row;
            ``weights``: 2^-27 to 2^27, which is 1e-8 to 1e8; ``dense``: 2^-10 to 2^10.
        n: length of chi.
        sizes: of the levels.
        soft: the share of inequality rows.
    """
    levels = tuple(_level(rng, scales, n, m, soft) for m in sizes)
    lower, upper = (
        -rng.integers(0, 4, size=n).astype(float),
        rng.integers(0, 4, size=n).astype(float),
    )
    if rng.random() < 0.15:
        upper[rng.integers(n)] = 1e5 * rng.integers(1, 9)
    return HqpProblem(levels, Bounds(lower, upper))


def shape(rng):
    """Return how many joints a problem has, and how many rows its levels have."""
    sizes = [int(rng.integers(1, 5)) for _ in range(rng.integers(1, 4))]
    return int(rng.integers(2, 6)), sizes


def _level(rng, scales, n, m, soft):
    matrix = rng.integers(-3, 4, size=(m, n)).astype(float)
    if m > 1 and rng.random() < 0.3:
        matrix[-1] = matrix[0] * rng.integers(-2, 3)
    target = rng.integers(-5, 6, size=m).astype(float)
    lower, upper = target.copy(), target.copy()
    for i in np.flatnonzero(rng.random(m) < soft):
        kind = rng.integers(3)
        if kind == 0:
            upper[i] = np.inf
        elif kind == 1:
            lower[i] = -np.inf
        else:
            upper[i] += rng.integers(0, 3)
    exponent = {
        "one": lambda: np.zeros(m, dtype=int),
        "levels": lambda: np.full(m, rng.integers(-20, 21)),
        "rows": lambda: rng.integers(-20, 21, size=m),
        "weights": lambda: rng.integers(-27, 28, size=m),
        "dense": lambda: rng.integers(-10, 11, size=m),
    }[scales]()
    s = np.ldexp(1.0, exponent)
    # A task for each row: rows that are tiny beside others of their task count as rounding.
    return tuple(
        LinearTask(
            f"row_{i}",
            s[i] * matrix[i : i + 1],
            s[i] * lower[i : i + 1],
            s[i] * upper[i : i + 1],
        )
        for i in range(m)
    )
