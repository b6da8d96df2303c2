"""What the benches are to reach, in one place: thread CPU time, in turns within one run.

Every row names the figures of a bench by a pattern; the worst of them stands for the row. A goal is
that of the row, a moonshot what would be more than was asked for.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from lexstack_experiments.results import Cell, Figure, Goal, Table
from lexstack_experiments.text import goal_text, number

TITLE = "goals of speed"
_COLUMNS = ("bench", "row", "goal", "moonshot", "ours", "", "worst of")
_NOT_HERE = "not in this run"


@dataclass(frozen=True, slots=True)
class Row:
    """One row of the table of goals.

    Attributes:
        bench: whose figures count.
        text: what the row says.
        pattern: what the whole name of a figure matches.
        limit: of the goal, in the figure's unit.
        moonshot: likewise; None without one.
        unit: of both.
        comparison: of the figure with the goal.
    """

    bench: str
    text: str
    pattern: str
    limit: float
    moonshot: float | None = None
    unit: str = ""
    comparison: Literal["<=", ">=", "=="] = "<="

    @property
    def goal(self) -> Goal:
        """The goal."""
        return Goal(self.comparison, self.limit)

    def worst(self, figures: Iterable[Figure]) -> Figure | None:
        """Return the figure of the row that is farthest from its goal; None without any."""
        known = [f for f in figures if f.value is not None and re.fullmatch(self.pattern, f.name)]
        choose = min if self.comparison == ">=" else max
        return choose(known, key=lambda figure: figure.value or 0.0, default=None)


def _horizon(stages: int, spheres: bool, limits: tuple[float, ...]) -> tuple[Row, Row]:
    """Return the rows of one horizon: goals of p50 and p99, then their moonshots [ms]."""
    what = f"N = {stages}{', 10 spheres' if spheres else ''}"
    return tuple(
        Row("htmpc", f"{what}: {kind}", rf"\w+, {what}, lexstack: {kind}", goal, far, "ms")
        for kind, goal, far in zip(("p50", "p99"), limits[:2], limits[2:], strict=True)
    )


_PLAIN = r"(follow-chi to \w+|base|posture)"

ROWS: tuple[Row, ...] = (
    Row("hqp", "follow-chi: p50", r"follow-chi to \w+: p50", 20.0, 15.0, "us"),
    Row("hqp", "base: p50", r"base: p50", 25.0, 18.0, "us"),
    Row("hqp", "posture: p50", r"posture: p50", 28.0, 20.0, "us"),
    Row("hqp", "their p99", rf"{_PLAIN}: p99", 45.0, 35.0, "us"),
    Row("hqp", "at bounds: p50", r".*, at bounds: p50", 30.0, 20.0, "us"),
    Row("hqp", "at bounds: p99", r".*, at bounds: p99", 70.0, 45.0, "us"),
    Row("hqp", "distances: p50", r".*distances.*: p50", 35.0, 24.0, "us"),
    Row("hqp", "distances: p99", r".*distances.*: p99", 90.0, 55.0, "us"),
    Row("hqp", "p50 over DAQP hierarchical", r".*: p50 over DAQP hierarchical", 0.5, 0.35),
    Row("hqp", "failures", r"Failures of the default solver", 0.0, None, "", "=="),
    Row(
        "tick", "two robots, outside a blend", r"2 robots, outside a blend: p50", 100.0, 65.0, "us"
    ),
    Row("tick", "two robots, in a blend", r"2 robots, in a blend: p50", 130.0, 90.0, "us"),
    Row("transition", "outside a blend", r".*, idle: p50 of a tick", 100.0, 65.0, "us"),
    Row("transition", "in a blend", r".*, blending: p50 of a tick", 130.0, 90.0, "us"),
    Row("scaling", "32 robots over 2", r"whole tick, 32 robots over 2", 10.0, 8.0, "x"),
    *_horizon(10, False, (1.0, 4.0, 0.7, 3.0)),
    *_horizon(20, False, (3.0, 8.0, 2.2, 6.0)),
    *_horizon(30, False, (7.0, 14.0, 5.0, 10.0)),
    *_horizon(10, True, (2.0, 7.0, 1.3, 5.0)),
    *_horizon(20, True, (5.0, 11.0, 3.5, 8.0)),
    *_horizon(30, True, (10.0, 22.0, 7.0, 14.0)),
    Row("htmpc", "N = 10: p99 over before", r"\w+, N = 10, lexstack: p99 over .*", 0.5),
    Row("htmpc", "N = 20: p99 over before", r"\w+, N = 20, lexstack: p99 over .*", 1.0 / 3.0),
    Row("htmpc", "N = 30: p99 over before", r"\w+, N = 30, lexstack: p99 over .*", 0.25),
    Row(
        "htmpc",
        "the paper's way over ours",
        r"\w+, N = 10, authors: the paper's way over ours",
        *(25.0, 40.0),
        comparison=">=",
    ),
    Row("htmpc", "failed levels", r"Solves with a failed level", 0.0, None, "", "=="),
)
"""In the order in which they are shown."""


def goal_of(bench: str, name: str) -> Goal | None:
    """Return the goal of a bench's figure, None if it has none."""
    rows = (row for row in ROWS if row.bench == bench and re.fullmatch(row.pattern, name))
    return next((row.goal for row in rows), None)


def with_goals(bench: str, figures: Iterable[Figure]) -> tuple[Figure, ...]:
    """Return a bench's figures as they are to be shown: with their goals, ratios before times."""
    listed = [
        Figure(f.name, f.value, f.unit, f.goal or goal_of(bench, f.name), f.paper, f.peer)
        for f in figures
    ]
    return tuple(sorted(listed, key=lambda figure: figure.unit not in {"", "x"}))


def table_of(found: Mapping[str, Iterable[Figure]]) -> Table:
    """Return every row of the benches that ran, with goal, moonshot, and whether it is reached.

    Args:
        found: figures by bench.
    """
    return Table(
        _COLUMNS, [_line(row, row.worst(found[row.bench])) for row in _asked(found)], TITLE
    )


def figures_of(found: Mapping[str, Iterable[Figure]]) -> tuple[Figure, ...]:
    """Return every row of the benches that ran as a figure with its goal."""
    shown = []
    for row in _asked(found):
        worst = row.worst(found[row.bench])
        value = None if worst is None else worst.value
        shown.append(Figure(f"{row.bench}: {row.text}", value, row.unit, row.goal))
    return tuple(shown)


def _asked(found: Mapping[str, Iterable[Figure]]) -> list[Row]:
    """Return the rows of some benches."""
    return [row for row in ROWS if row.bench in found]


def _line(row: Row, worst: Figure | None) -> tuple[Cell, ...]:
    """Return a row of the table."""
    goal = goal_text(Figure(row.text, None, row.unit, row.goal))
    far = None if row.moonshot is None else number(row.moonshot)
    if worst is None or worst.value is None:
        return row.bench, row.text, goal, far, None, _NOT_HERE, ""
    word = "reached" if row.goal.reached(worst.value) else "NOT reached"
    if row.moonshot is not None and Goal(row.comparison, row.moonshot).reached(worst.value):
        word = "reached, and the moonshot"
    return row.bench, row.text, goal, far, number(worst.value), word, worst.name
