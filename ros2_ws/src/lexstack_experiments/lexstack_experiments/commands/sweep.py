"""``scripts/sweep FILE``: many runs over grids and random values, on all cores or a cluster."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from lexstack.errors import ConfigurationError, LexstackError
from lexstack_bag.storage.folders import writing
from lexstack_config.yaml_text import read_text
from lexstack_experiments.machine import Machine, commit_here
from lexstack_experiments.sweeps.execution import batches, run_batch, spread
from lexstack_experiments.sweeps.report import page
from lexstack_experiments.sweeps.storage import RUNS, SweepFolder
from lexstack_experiments.sweeps.summary import failures, limits_kept
from lexstack_experiments.sweeps.sweep_file import SweepFile, load_sweep

FAILED, BAD_ARGUMENT, INTERRUPTED = 1, 2, 130
_EVERY = 5.0  # s between two lines of progress


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns:
        0 when all runs are done; 1 when the sweep could not be done, or with ``--strict`` when a
        limit is broken or not judged, or a run failed; 2 for bad arguments; 130 after Ctrl-C: what
        is done is kept, and the same command goes on.
    """
    root = Path(os.environ.get("LEXSTACK_ROOT", ".")).resolve()
    parsed = _parser().parse_args(arguments)
    out = parsed.out
    try:
        path = _find(parsed.sweep, root / "config")
        sweep = load_sweep(path)
        stamp = datetime.now().strftime("%Y%m%d-%H%M%S")
        out = out or root / "runs" / f"sweep-{sweep.name}-{stamp}"
        folder = SweepFolder(out, read_text(path))
        return _run(sweep, folder, root / "config", parsed)
    except LexstackError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_ARGUMENT if isinstance(error, ConfigurationError) else FAILED
    except KeyboardInterrupt:
        print(f"interrupted: go on with the same command and --out {out}", file=sys.stderr)
        return INTERRUPTED


def _run(sweep: SweepFile, folder: SweepFolder, config: Path, parsed: argparse.Namespace) -> int:
    """Do what is not done yet, gather, report; returns the exit code."""
    size = min(sweep.size, parsed.first or sweep.size)
    already = folder.done()
    left = [index for index in range(size) if index not in already]
    print(f"{sweep.name}: {size} runs, {size - len(left)} of them done before", file=sys.stderr)
    if left:
        folder.keep(run_batch(sweep, config, left[:1]))  # an error of the file is told at once
        left = left[1:]
    progress = _Progress(len(left))
    for done in spread(sweep, config, batches(left, parsed.batch), parsed.cluster, parsed.workers):
        folder.keep(done)
        progress.advance(len(done.indices))
    runs = folder.gather()
    here = Machine.here()
    facts = (
        f"{runs.num_rows} runs, seed {sweep.seed}, commit {commit_here()}; gathered on "
        f"{here.cores} cores ({here.processor}), Python {here.python}."
    )
    report = folder.path / "report.html"
    with writing(report):
        report.write_text(page(sweep, runs, facts), encoding="utf-8")
    broken = 0
    for kept in limits_kept(runs, sweep):
        broken += kept.broken or not kept.runs
        if not kept.runs:
            print(f"{kept.figure} {kept.limit}: not judged, no run has this figure as a number")
            continue
        print(
            f"{kept.figure} {kept.limit}: broken in {kept.broken} of {kept.runs} runs; chance "
            f"<= {kept.bound:.2g} at 95 % confidence; nearest or beyond: run {kept.worst}"
        )
    failed = failures(runs)
    if failed:
        print(
            f"{len(failed)} runs could not be done; the first, run {failed[0][0]}: {failed[0][1]}"
        )
    print(f"wrote {folder.path / RUNS} and {report}", file=sys.stderr)
    return FAILED if parsed.strict and (broken or failed) else 0


def _find(named: str, config: Path) -> Path:
    """Return the sweep's file: a path, or a name in config/sweeps."""
    path = Path(named)
    if path.suffix == ".yaml":
        return path
    path = config / "sweeps" / f"{named}.yaml"
    if not path.is_file():
        known = ", ".join(sorted(each.stem for each in path.parent.glob("*.yaml")))
        raise ConfigurationError(f"no sweep {named!r}; known: {known}; or a file, ending in .yaml")
    return path


def _parser() -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(
        prog="./scripts/sweep",
        description="Run a sweep: many runs over a grid, random values and seeds. Results: "
        "one Parquet file, which pandas opens, and a page with their distributions. The same "
        "command with the same --out goes on where it ended.",
    )
    parser.add_argument("sweep", help="a name of config/sweeps, or a file ending in .yaml")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="empty, or of the same sweep (default: runs/...)"
    )
    parser.add_argument(
        "--cluster",
        default="",
        metavar="ADDRESS",
        help="ray://HOST:PORT or ray:ADDRESS (Ray), or tcp://HOST:PORT (Dask); each of its "
        "machines needs this clone, set up, at the same path (default: this machine)",
    )
    parser.add_argument(
        "--workers", type=_positive, default=0, metavar="N", help="processes here (default: cores)"
    )
    parser.add_argument(
        "--batch", type=_positive, default=10, metavar="N", help="runs per call (default: 10)"
    )
    parser.add_argument(
        "--first", type=_positive, metavar="N", help="do the first N runs only (default: all)"
    )
    parser.add_argument(
        "--strict", action="store_true", help="exit with 1 where a limit is broken or a run failed"
    )
    return parser


def _positive(text: str) -> int:
    """Return a whole number of at least 1."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, got {value}")
    return value


class _Progress:
    """Prints how much is done, and when the rest will be."""

    def __init__(self, total: int) -> None:
        """Start the clock."""
        self._total, self._done = total, 0
        self._begun = self._told = time.monotonic()

    def advance(self, number: int) -> None:
        """Count some runs as done; say so every few seconds, and at the end."""
        self._done += number
        now = time.monotonic()
        if now - self._told < _EVERY and self._done < self._total:
            return
        self._told, spent = now, now - self._begun
        left = spent * (self._total - self._done) / self._done
        print(
            f"{spent:7.1f} s  {self._done} of {self._total} runs, about {left:.0f} s left",
            file=sys.stderr,
            flush=True,
        )


if __name__ == "__main__":
    sys.exit(main())
