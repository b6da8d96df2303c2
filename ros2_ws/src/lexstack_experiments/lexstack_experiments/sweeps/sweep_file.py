"""The schema of ``config/sweeps/*.yaml``: what is run, over which values, and what must hold."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import Finite, Name, NotEmpty, Range, shown
from lexstack_config.reader import build, read_yaml

_LARGEST = 2**53  # integers up to it are numbers of double precision, each
_MOST = 10_000_000  # runs in all
_OWN = ("seed", "run", "error")  # columns that every table of runs has

Values = dict[str, Any]
"""The values of one run by their keys."""


@dataclass(frozen=True, slots=True)
class UniformConfig:
    """Any number of an interval, each as likely."""

    low: Finite  # in the unit of the value
    high: Finite  # in the unit of the value
    of: Literal["numbers", "integers", "logarithms"] = "numbers"  # which are uniform
    type: Literal["uniform"] = "uniform"  # tells it from a list

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for an interval without numbers."""
        if self.high < self.low:
            raise ConfigurationError(f"{where}: high: must be at least low, {self.low:g}")
        if self.of == "logarithms" and self.low <= 0.0:
            raise ConfigurationError(f"{where}: low: must be above 0, it has no logarithm")
        if self.of == "integers" and max(abs(self.low), abs(self.high)) > _LARGEST:
            raise ConfigurationError(f"{where}: low and high of an integer must be within 2^53")
        if not np.isfinite(self.high - self.low):
            raise ConfigurationError(f"{where}: high: the interval from {self.low:g} is too wide")
        if self.of == "integers" and (self.low % 1.0 or self.high % 1.0):
            raise ConfigurationError(f"{where}: low and high of an integer must be integers")

    def draw(self, rng: np.random.Generator) -> float | int:
        """Return a number."""
        if self.of == "integers":
            return int(rng.integers(int(self.low), int(self.high) + 1))
        if self.of == "logarithms":
            return float(np.exp(rng.uniform(np.log(self.low), np.log(self.high))))
        return float(rng.uniform(self.low, self.high))


@dataclass(frozen=True, slots=True)
class OneOfConfig:
    """One value of a list, each as likely; a value that stands twice is twice as likely."""

    values: Annotated[tuple[Any, ...], NotEmpty("at least one value is needed")]  # to draw from
    type: Literal["one_of"] = "one_of"  # tells it from an interval

    def draw(self, rng: np.random.Generator) -> Any:
        """Return a value."""
        return self.values[int(rng.integers(len(self.values)))]


@dataclass(frozen=True, slots=True)
class LimitConfig:
    """What a figure of every run must be."""

    least: Finite | None = None  # in the unit of the figure
    most: Finite | None = None  # in the unit of the figure

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a limit that limits nothing."""
        if self.least is None and self.most is None:
            raise ConfigurationError(f"{where}: least or most is needed")

    def kept(self, figures: np.ndarray) -> np.ndarray:
        """Return which figures (m,) keep it; one that is not a number does not."""
        least = -np.inf if self.least is None else self.least
        most = np.inf if self.most is None else self.most
        return (figures >= least) & (figures <= most)


@dataclass(frozen=True, slots=True)
class SweepFile:
    """A sweep: every combination of the grid, each with so many runs of random values."""

    name: Name  # of the file
    description: str  # in a sentence
    run: Literal["promises", "scenario", "experiment", "fault"]  # what one run is
    of: str = ""  # which scenario, experiment or case of `experiment faults`
    grid: dict[str, tuple[Any, ...]] = field(default_factory=dict)  # by key: all values
    random: dict[str, UniformConfig | OneOfConfig] = field(default_factory=dict)  # by key
    runs: Annotated[int, Range(1, _MOST)] = 1  # of each combination of the grid
    seed: Annotated[int, Range(0, 2**31 - 1)] = 0  # of all random values
    limits: dict[str, LimitConfig] = field(default_factory=dict)  # by figure: what must hold

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a key that is both or no value, or too many runs."""
        for key in _OWN:
            if key in self.grid or key in self.random:
                raise ConfigurationError(f"{where}: {key}: every run has its own; remove it")
        for key, values in self.grid.items():
            if not values:
                raise ConfigurationError(f"{where}: grid.{shown(key)}: no values")
            if key in self.random:
                raise ConfigurationError(f"{where}: random.{shown(key)}: is in the grid too")
        if self.size > _MOST:
            raise ConfigurationError(f"{where}: grid: {self.size} runs in all, at most {_MOST}")

    @property
    def combinations(self) -> list[Values]:
        """All combinations of the grid, the last key changes fastest."""
        return [
            dict(zip(self.grid, chosen, strict=True)) for chosen in product(*self.grid.values())
        ]

    @property
    def size(self) -> int:
        """How many runs there are."""
        return self.runs * math.prod(len(values) for values in self.grid.values())

    def values(self, index: int) -> Values:
        """Return the values of a run, with its ``seed``.

        They depend on the sweep's seed and the run's number alone: runs can be done in any order,
        anywhere, and again. The runs of one number in all combinations have the same random
        values, so that combinations are compared over the same cases.

        Args:
            index: of the run, from 0.
        """
        combination, number = divmod(index, self.runs)
        rng = np.random.default_rng([self.seed, number])
        drawn = {key: chance.draw(rng) for key, chance in self.random.items()}
        chosen = {}
        for key, axis in reversed(self.grid.items()):  # the last key changes fastest
            combination, place = divmod(combination, len(axis))
            chosen[key] = axis[place]
        grid = {key: chosen[key] for key in self.grid}
        return {**grid, **drawn, "seed": int(rng.integers(2**31))}


def load_sweep(path: Path) -> SweepFile:
    """Return a sweep file; raises ConfigurationError with file and key."""
    sweep = build(SweepFile, read_yaml(path), str(path))
    if sweep.name != path.stem:
        raise ConfigurationError(f"{path}: name: expected {path.stem!r}, got {shown(sweep.name)}")
    return sweep
