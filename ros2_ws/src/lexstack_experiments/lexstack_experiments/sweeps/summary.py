"""What the runs of a sweep say: which limits hold in how many runs, and how figures spread."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from scipy.stats import binomtest

from lexstack.types import Vector
from lexstack_experiments.sweeps.execution import ERROR
from lexstack_experiments.sweeps.storage import INDEX
from lexstack_experiments.sweeps.sweep_file import LimitConfig, SweepFile

_LEVEL = 0.95
QUANTILES = (0.5, 0.9, 0.99, 1.0)


@dataclass(frozen=True, slots=True)
class Kept:
    """In how many runs a limit holds.

    Attributes:
        figure: its name.
        limit: in words.
        runs: that have the figure.
        broken: of these, how many break the limit.
        bound: of the chance that a run breaks it, the upper bound at 95 % confidence (Clopper and
            Pearson 1934); with no broken run of n it is 3.7 / n.
        worst: the number of the run farthest off, or of the one nearest to the limit.
    """

    figure: str
    limit: str
    runs: int
    broken: int
    bound: float
    worst: int


def figures_of(table: pa.Table, sweep: SweepFile) -> dict[str, Vector]:
    """Return the figures by name, shape (runs,), NaN where a run has none; without the values."""
    values = {INDEX, ERROR, "seed", *sweep.grid, *sweep.random}
    return {
        name: numbers(table, name)
        for name in table.column_names
        if name not in values and _is_number(table.schema.field(name).type)
    }


def numbers(table: pa.Table, name: str) -> Vector:
    """Return a column as numbers (runs,), NaN where a run has none."""
    column = table[name].to_pylist()
    return np.array([np.nan if value is None else float(value) for value in column])


def limits_kept(table: pa.Table, sweep: SweepFile) -> list[Kept]:
    """Return for each limit of a sweep in how many runs it holds; in none where none has it."""
    figures = figures_of(table, sweep)
    return [
        _kept(name, limit, *_having(table, name if name in figures else None))
        for name, limit in sweep.limits.items()
    ]


def _having(table: pa.Table, name: str | None) -> tuple[Vector, Vector]:
    """Return the figure in the runs that have it, and their numbers; NaN is a figure."""
    if name is None:
        return np.zeros(0), np.zeros(0)
    has = table[name].is_valid().to_numpy()
    return numbers(table, name)[has], table[INDEX].to_numpy()[has]


def _kept(name: str, limit: LimitConfig, figures: Vector, indices: Vector) -> Kept:
    """Return in how many of the runs that have a figure its limit holds."""
    least, most = limit.least, limit.most
    ends = {">=": least, "<=": most}
    words = " and ".join(f"{sign} {end:g}" for sign, end in ends.items() if end is not None)
    if not figures.size:
        return Kept(name, words, 0, 0, 1.0, -1)
    broken = int(np.count_nonzero(~limit.kept(figures)))
    bound = float(binomtest(broken, figures.size).proportion_ci(_LEVEL, "exact").high)
    above = figures - most if most is not None else np.full(figures.shape, -np.inf)
    below = least - figures if least is not None else np.full(figures.shape, -np.inf)
    worst = int(indices[int(np.argmax(np.maximum(above, below)))])
    return Kept(name, words, figures.size, broken, bound, worst)


def failures(table: pa.Table) -> list[tuple[int, str]]:
    """Return the runs that could not be done, by number, with their reasons."""
    if ERROR not in table.column_names:
        return []
    pairs = zip(table[INDEX].to_pylist(), table[ERROR].to_pylist(), strict=True)
    return [(index, text) for index, text in pairs if text]


def quantiles(figures: Vector) -> tuple[float, ...]:
    """Return the median, the 90th and 99th percentile and the largest of what is finite."""
    finite = figures[np.isfinite(figures)]
    return tuple(float(value) for value in np.quantile(finite, QUANTILES)) if finite.size else ()


def _is_number(kind: pa.DataType) -> bool:
    return bool(
        pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind)
    )
