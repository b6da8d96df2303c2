"""What an experiment or bench leaves: its figures, its main table, and how they were made."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from lexstack_experiments.machine import Machine, commit_here
from lexstack_experiments.quiet import Quiet

Cell = str | float | int | None
"""A cell of a table; None where a row has no such figure."""

_HOLDS = {
    "<=": lambda value, limit, slack: value <= limit + slack,
    ">=": lambda value, limit, slack: value >= limit - slack,
    "==": lambda value, limit, slack: abs(value - limit) <= slack,
}


@dataclass(frozen=True, slots=True)
class Goal:
    """What a figure is to reach.

    Attributes:
        comparison: of the value with the limit.
        limit: in the figure's unit.
        slack: rounding that still counts as reached, in the figure's unit.
    """

    comparison: Literal["<=", ">=", "=="]
    limit: float
    slack: float = 0.0

    def reached(self, value: float) -> bool:
        """Return whether a value meets the goal."""
        return _HOLDS[self.comparison](value, self.limit, self.slack)


AT_MOST_ONE = Goal("<=", 1.0, 1e-6)
"""Of a ratio that may meet its limit exactly."""


@dataclass(frozen=True, slots=True)
class Peer:
    """The same figure of somebody else: another method, solver or library, in the same run."""

    name: str
    value: float | None


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure of an experiment.

    Attributes:
        name: what it says.
        value: ours; None where this run does not show it (fewer cases than usual).
        unit: of value, goal and peer; empty for ratios and counts.
        goal: what it is to reach, or None.
        paper: the paper's figure as printed there, or empty.
        peer: a peer's or baseline's figure, or None.
    """

    name: str
    value: float | None
    unit: str = ""
    goal: Goal | None = None
    paper: str = ""
    peer: Peer | None = None

    def __post_init__(self) -> None:
        """Raise ValueError for a value that is not finite: leave it out instead."""
        for value in (self.value, self.peer.value if self.peer else None):
            if value is not None and not math.isfinite(value):
                raise ValueError(f"figure {self.name!r}: {value} is not finite")

    @property
    def reached(self) -> bool:
        """Whether the goal is reached; without a goal yes, without a value no."""
        if self.goal is None:
            return True
        return self.value is not None and self.goal.reached(self.value)


def zero(name: str, value: float | None, unit: str = "") -> Figure:
    """Return a figure that is to be zero."""
    return Figure(name, value, unit, Goal("==", 0.0))


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of equal length under the names of the columns (with their units)."""

    columns: tuple[str, ...]
    rows: Iterable[tuple[Cell, ...]]
    title: str = ""

    @classmethod
    def of(cls, rows: Iterable[Mapping[str, Cell]], title: str = "") -> Table:
        """Return a table of rows that name their cells, all of them alike."""
        listed = list(rows)
        columns = tuple(listed[0]) if listed else ()
        return cls(columns, [tuple(row[name] for name in columns) for row in listed], title)

    def __post_init__(self) -> None:
        """Keep the rows as a tuple; raise ValueError for a row of another length."""
        rows = tuple(self.rows)
        object.__setattr__(self, "rows", rows)
        for row in rows:
            if len(row) != len(self.columns):
                raise ValueError(f"table: {len(row)} cells in {len(self.columns)} columns: {row}")


@dataclass(frozen=True, slots=True)
class Results:
    """All that an experiment has found.

    Attributes:
        name: of the experiment or bench.
        seed: of everything random in it.
        cases: how many it ran.
        figures: the figures to reach first.
        tables: the main table first.
        setup: what else was chosen, e.g. the control period, in units that its keys name.
        notes: what a reader of the table must know, in whole sentences.
        machine: what it ran on.
        commit: of the source that ran; with a plus sign where files differed from it.
        quiet: whether the machine was left to it; None where nobody looked.
    """

    name: str
    seed: int
    cases: int
    figures: tuple[Figure, ...]
    tables: tuple[Table, ...] = ()
    setup: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    machine: Machine = field(default_factory=Machine.here)
    commit: str = field(default_factory=commit_here)
    quiet: Quiet | None = None

    @property
    def goals(self) -> tuple[Figure, ...]:
        """The figures that have a goal."""
        return tuple(figure for figure in self.figures if figure.goal is not None)

    @property
    def all_reached(self) -> bool:
        """Whether every goal is reached."""
        return all(figure.reached for figure in self.figures)

    def to_json(self) -> str:
        """Return the text of ``results.json``; it never holds NaN.

        Each figure also says whether it is reached (null without a goal); each row of a table is
        an object with the columns as keys.
        """
        content = asdict(self)
        for figure, entry in zip(self.figures, content["figures"], strict=True):
            entry["reached"] = None if figure.goal is None else figure.reached
        content["tables"] = [
            {
                "title": table.title,
                "rows": [dict(zip(table.columns, row, strict=True)) for row in table.rows],
            }
            for table in self.tables
        ]
        return json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
