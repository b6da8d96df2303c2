"""What an experiment or bench is: a function from options to results, with a summary."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lexstack_experiments.results import Figure, Results, Table


@dataclass(frozen=True, slots=True)
class Options:
    """What the command line says.

    Attributes:
        config: the folder with scenarios, stacks and robots.
        out: an empty folder for pictures and other files of the experiment.
        seed: of everything random.
        cases: how many cases to run, at least 1.
        seconds: how long it shall run, where it has a duration; 0: as usual.
        say: told what happens, in single lines.
        against: another clone of the project to compare with, where that can be done.
    """

    config: Path
    out: Path
    seed: int
    cases: int
    say: Callable[[str], None] = lambda _line: None
    seconds: float = 0.0
    against: Path | None = None

    def results(
        self,
        name: str,
        figures: Iterable[Figure],
        tables: Table | Iterable[Table] = (),
        setup: Mapping[str, Any] | None = None,
        notes: tuple[str, ...] = (),
    ) -> Results:
        """Return what an experiment of this name has found, with the seed and the cases."""
        listed = (tables,) if isinstance(tables, Table) else tuple(tables)
        given = (tuple(figures), listed, dict(setup or {}), notes)
        return Results(name, self.seed, self.cases, *given)


@dataclass(frozen=True, slots=True)
class Experiment:
    """An experiment or bench as it is registered.

    Attributes:
        summary: one line for ``--help``.
        case: what ``--cases`` counts, in the plural.
        cases: how many a full run has.
        run: does it.
        seconds: its usual duration of wall time [s], if it has one.
        soak: its duration with ``--soak`` [s].
        compares: whether it can run another clone of the project, in turns with this one.
    """

    summary: str
    case: str
    cases: int
    run: Callable[[Options], Results]
    seconds: float = 0.0
    soak: float = 0.0
    compares: bool = False
