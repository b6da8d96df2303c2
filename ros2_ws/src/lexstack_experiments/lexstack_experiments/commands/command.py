"""What both commands do: read the arguments, run by name, write results.json, print the table."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path

from lexstack.errors import ConfigurationError, LexstackError
from lexstack_bag.storage.folders import empty_folder
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.text import lines_of

FAILED, BAD_ARGUMENT, INTERRUPTED = 1, 2, 130
_LONGEST = 86_400.0  # s


def run_command(
    kind: str, known: Mapping[str, Experiment], arguments: list[str] | None = None
) -> int:
    """Run an experiment or bench by name.

    Args:
        kind: ``experiment`` or ``bench``.
        known: what can be run, by name.
        arguments: of the command line; None: those of the process.

    Returns:
        0 when it ran to its end; 1 when it did not, or with ``--strict`` when a goal was missed;
        2 for bad arguments; 130 after Ctrl-C.
    """
    root = Path(os.environ.get("LEXSTACK_ROOT", ".")).resolve()
    parsed = _parser(kind, known).parse_args(arguments)
    experiment = known[parsed.name]
    try:
        options = _options(root, kind, experiment, parsed)
        return _run(experiment, options, parsed.strict)
    except LexstackError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_ARGUMENT if isinstance(error, ConfigurationError) else FAILED
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        return INTERRUPTED


def _run(experiment: Experiment, options: Options, strict: bool) -> int:
    """Run, write, print; returns the exit code."""
    results = experiment.run(options)
    path = options.out / "results.json"
    path.write_text(results.to_json(), encoding="utf-8")
    options.say(f"wrote {path}")
    print("\n".join(lines_of(results)))
    return FAILED if strict and not results.all_reached else 0


def _parser(kind: str, known: Mapping[str, Experiment]) -> argparse.ArgumentParser:
    """Return the command line."""
    width = max(len(name) for name in known)
    listed = [
        f"  {name:{width}}  {entry.summary} ({entry.cases} {entry.case})"
        for name, entry in known.items()
    ]
    parser = argparse.ArgumentParser(
        prog=f"./scripts/{kind}",
        description=f"Run one {kind} by its name:\n" + "\n".join(listed),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("name", metavar="NAME", choices=tuple(known), help="one of the names above")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help=f"empty folder (default: runs/{kind}-NAME-TIME)"
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="of everything random (default: 0)"
    )
    parser.add_argument(
        "--cases", type=int, metavar="N", help="run the first N cases only (default: all)"
    )
    parser.add_argument(
        "--strict", action="store_true", help="exit with 1 unless every goal is reached"
    )
    lasting = [name for name, entry in known.items() if entry.seconds]
    if lasting:
        which = ", ".join(lasting)
        parser.add_argument(
            "--duration", type=float, metavar="S", help=f"of the realtime run [s] ({which})"
        )
        parser.add_argument("--soak", action="store_true", help=f"30 minutes of it ({which})")
    comparing = [name for name, entry in known.items() if entry.compares]
    if comparing:
        parser.add_argument(
            "--against",
            type=Path,
            metavar="FOLDER",
            help="compare with another clone that was set up, in turns "
            f"({', '.join(comparing)}, in lockstep)",
        )
    return parser


def _options(root: Path, kind: str, experiment: Experiment, parsed: argparse.Namespace) -> Options:
    """Return the checked options with their folder made; raises ConfigurationError."""
    if not 0 <= parsed.seed < 2**31:
        raise ConfigurationError(f"--seed: must be in [0, 2^31), got {parsed.seed}")
    if parsed.cases is not None and not 1 <= parsed.cases <= experiment.cases:
        raise ConfigurationError(
            f"--cases: must be in [1, {experiment.cases}] ({experiment.case}), got {parsed.cases}"
        )
    against = getattr(parsed, "against", None)
    if against is not None and not experiment.compares:
        raise ConfigurationError(f"{parsed.name} compares with no other clone: leave --against out")
    seconds = _seconds(experiment, parsed)
    stamp = datetime.now().strftime("%Y%m%d-%H%M%S")
    out = empty_folder(parsed.out or root / "runs" / f"{kind}-{parsed.name}-{stamp}")
    cases = parsed.cases or experiment.cases
    return Options(root / "config", out, parsed.seed, cases, _Teller(), seconds, against)


def _seconds(experiment: Experiment, parsed: argparse.Namespace) -> float:
    """Return how long it shall run [s], 0 where it has no duration; raises ConfigurationError."""
    given, soak = getattr(parsed, "duration", None), getattr(parsed, "soak", False)
    if (given is not None or soak) and not experiment.seconds:
        raise ConfigurationError(f"{parsed.name} has no duration: leave --duration and --soak out")
    if given is not None and not 1.0 <= given <= _LONGEST:
        raise ConfigurationError(f"--duration: must be in [1, {_LONGEST:g}] s, got {given:g}")
    return experiment.soak if soak else given or experiment.seconds


class _Teller:
    """Prints progress with the time since the start, beside the results on stdout."""

    def __init__(self) -> None:
        """Start the clock."""
        self._begun = time.monotonic()

    def __call__(self, line: str) -> None:
        """Print one line."""
        print(f"{time.monotonic() - self._begun:6.1f} s  {line}", file=sys.stderr, flush=True)
