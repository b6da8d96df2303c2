"""Analyses the bag of a run: writes metrics.json and report.html, prints the table."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from lexstack_bag.errors import BagError
from lexstack_bag.goals import summary_lines
from lexstack_bag.measures import measure
from lexstack_bag.metrics import Metrics, compute_metrics
from lexstack_bag.phases import find_phases
from lexstack_bag.progress import ProgressBar
from lexstack_bag.reader import read_run
from lexstack_bag.report.build import write_report
from lexstack_core.errors import LexstackError

BAD_ARGUMENT = 2


def analyze(
    bag: Path, out: Path | None = None, progress: Callable[[str], None] = lambda _line: None
) -> Metrics:
    """Analyse a bag and write ``metrics.json`` and ``report.html``.

    Args:
        bag: a run folder, a bag folder or an .mcap file.
        out: where to write; default: the run folder, beside the bag folder.
        progress: told what happens, in single lines.

    Returns:
        The figures that were written.

    Raises:
        BagError: the bag cannot be read, or the results cannot be written.
    """
    run = read_run(bag, ProgressBar("reading"))
    total = sum(run.messages.values())
    progress(f"read {total} messages of {len(run.messages)} topics from {run.path.name}")
    folder = out or run_folder(run.path)
    measures = measure(run)
    phases = find_phases(run)
    metrics = compute_metrics(run, measures, phases)
    progress(f"computed the figures of {metrics.ticks} ticks in {len(phases)} phases")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "metrics.json").write_text(metrics.to_json(), encoding="utf-8")
        report = folder / "report.html"
        write_report(report, run, measures, phases, metrics, progress)
    except OSError as error:
        raise BagError(f"{folder}: cannot be written: {error.strerror}") from error
    progress(f"wrote {folder / 'metrics.json'} and {report}")
    return metrics


def run_folder(file: Path) -> Path:
    """Return the run folder of an .mcap file; a file on its own keeps its results beside it."""
    bag = file.resolve().parent
    return bag.parent if bag.name == "bag" or (bag / "metadata.yaml").is_file() else bag


def main() -> int:
    """Run the command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="./scripts/analyze", description=__doc__)
    parser.add_argument("bag", type=Path, help="run folder, bag folder or .mcap file")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="where to write (default: the run folder)"
    )
    arguments = parser.parse_args()
    try:
        metrics = analyze(arguments.bag, arguments.out, lambda line: print(line, flush=True))
    except LexstackError as error:
        print(f"analyze: {error}", file=sys.stderr)
        return BAD_ARGUMENT
    print("\n" + "\n".join(summary_lines(metrics)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
