"""The same bench in another clone of this project, in turns with ours: ratios within one run.

Both sides run the same program in a process each, ours in this source tree, the other in that of
``--against FOLDER``. They are measured alternately, and who begins changes from turn to turn.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lexstack.hqp import Hierarchy, HqpProblem
from lexstack_experiments.benches.child import Child
from lexstack_experiments.experiment import Options
from lexstack_experiments.hierarchies import recorded
from lexstack_experiments.measuring import paired_ratio
from lexstack_experiments.results import Figure, Table

Turn = Mapping[str, Sequence[float]]
"""What one turn has measured: times by the name of the row [us]."""

Found = tuple[tuple[Figure, ...], tuple[Table, ...]]
"""What a comparison adds to a bench: figures and a table."""

NOTHING: Found = ((), ())


@dataclass(frozen=True, slots=True)
class Compared:
    """One row on both sides.

    Attributes:
        name: of the row.
        p50: ours over theirs, median of the turns.
        p99: likewise.
        ours: p50 and p99 over all turns [us].
        theirs: likewise.
    """

    name: str
    p50: float
    p99: float
    ours: tuple[float, float]
    theirs: tuple[float, float]


def compared(ours: Sequence[Turn], theirs: Sequence[Turn]) -> list[Compared]:
    """Return the rows that both sides have, by turns in the order in which they were measured."""
    rows = []
    for name in ours[0]:
        if name not in theirs[0]:
            continue
        mine = np.array([turn[name] for turn in ours])
        other = np.array([turn[name] for turn in theirs])
        p50, p99 = (paired_ratio(mine, other, percent) for percent in (50.0, 99.0))
        both = (tuple(np.percentile(all_, (50.0, 99.0)).tolist()) for all_ in (mine, other))
        rows.append(Compared(name, p50, p99, *both))
    return rows


def alternately(
    turns: int, ours: Callable[[], Turn], theirs: Callable[[], Turn]
) -> tuple[list[Turn], list[Turn]]:
    """Return what both sides measure in turns: A B, B A, A B, ..."""
    mine, other = list[Turn](), list[Turn]()
    for number in range(turns):
        for side in (0, 1) if number % 2 == 0 else (1, 0):
            (mine, other)[side].append((ours, theirs)[side]())
    return mine, other


def against_tick(options: Options) -> Found:
    """Compare whole ticks, each side in its own closed loop of the paper's sequence."""
    with _pair("against_tick", options) as (here, there):
        return _compared(options, lambda: here.ask("turn"), lambda: there.ask("turn"))


def against_hqp(sequences: Mapping[str, recorded.Sequence], options: Options) -> Found:
    """Compare the default solvers on the same recorded problems."""
    with _pair("against_hqp", options) as (here, there):
        for name, sequence in sequences.items():
            problems = [_listed(problem) for problem in sequence.problems]
            for side in (here, there):
                side.ask("load", name=name, problems=problems)
        return _compared(options, lambda: here.ask("turn"), lambda: there.ask("turn"))


def against_htmpc(
    rows: Mapping[str, tuple[dict[str, Any], list[dict[str, Any]]]], options: Options, turns: int
) -> Found:
    """Compare solves on the same states.

    Args:
        rows: by name, what a row is and its states, as the worker takes them.
        options: of the command line.
        turns: how many.
    """
    with _pair("against_htmpc", options) as (here, there):
        for name, (row, states) in rows.items():
            for side in (here, there):
                side.ask("load", name=name, row=row, states=states)

        def turn(side: Child) -> Turn:
            return {name: side.ask("turn", name=name) for name in rows}

        return _compared(options, lambda: turn(here), lambda: turn(there), turns)


def label_of(folder: Path) -> str:
    """Return how a clone is called: by its commit, else by its name."""
    command = ["git", "-C", str(folder), "rev-parse", "--short=7", "HEAD"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout.strip() or folder.name


@contextmanager
def _pair(program: str, options: Options) -> Iterator[tuple[Child, Child]]:
    """Run a program in our source tree and in the other one."""
    assert options.against is not None
    with Child(program) as here, Child(program, source=options.against) as there:
        yield here, there


def _compared(
    options: Options, ours: Callable[[], Turn], theirs: Callable[[], Turn], turns: int = 0
) -> Found:
    """Measure in turns, the first of which warms up; return figures and a table."""
    assert options.against is not None
    label = label_of(options.against)
    mine, other = alternately((turns or options.cases) + 1, ours, theirs)
    rows = compared(mine[1:], other[1:])
    options.say(f"compared with {label}: {len(rows)} rows")
    figures = [
        Figure(f"{row.name}: {kind} over {label}", getattr(row, kind))
        for row in rows
        for kind in ("p50", "p99")
    ]
    columns = (
        "row",
        "p50 over its",
        "p99 over its",
        "us p50",
        "us p99",
        "its us p50",
        "its us p99",
    )
    lines = [(row.name, row.p50, row.p99, *row.ours, *row.theirs) for row in rows]
    return tuple(figures), (Table(columns, lines, f"ours over {label}, turn by turn"),)


def _listed(problem: HqpProblem) -> dict[str, Any]:
    """Return a problem as JSON holds it: the rows of each level, and the bounds."""
    n = problem.bounds.lower.size
    levels = []
    for level in problem.levels:
        rows = Hierarchy((level,), n)
        levels.append((rows.matrix, rows.lower, rows.upper))
    return {"levels": levels, "lower": problem.bounds.lower, "upper": problem.bounds.upper}
