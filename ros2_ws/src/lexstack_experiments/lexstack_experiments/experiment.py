"""What an experiment or bench is: a function from options to results, with a summary."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from lexstack_experiments.results import Results


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
    """

    config: Path
    out: Path
    seed: int
    cases: int
    say: Callable[[str], None] = lambda _line: None
    seconds: float = 0.0


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
    """

    summary: str
    case: str
    cases: int
    run: Callable[[Options], Results]
    seconds: float = 0.0
    soak: float = 0.0
