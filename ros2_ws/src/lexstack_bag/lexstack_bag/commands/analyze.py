"""Analyses the bag of a run: writes metrics.json and report.html, prints the table.

With two bags it analyses both, and writes and prints how their figures differ. A reset of the plant
begins a part of a bag: the last part's files stand in the folder, those of part 1 in part-1, and so
on.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from lexstack.errors import LexstackError
from lexstack.tasks import TASKS
from lexstack_bag.errors import BagError
from lexstack_bag.figures.compare import Comparison, compare_metrics
from lexstack_bag.figures.compare import summary_lines as difference_lines
from lexstack_bag.figures.export import write_csv, write_parquet
from lexstack_bag.figures.figures import Analysis, Metrics
from lexstack_bag.figures.goals import summary_lines
from lexstack_bag.progress import ProgressBar
from lexstack_bag.report.build import write_report
from lexstack_bag.report.comparison import write_comparison
from lexstack_bag.report.video import write_video
from lexstack_bag.run.reader import read_parts
from lexstack_bag.run.run import Run
from lexstack_bag.storage.folders import writing
from lexstack_config.extensions import load_extensions

BAD_ARGUMENT, INTERRUPTED = 2, 130
_MOST_PARTS = 20  # of a bag with resets, besides the last one


Say = Callable[[str], None]
"""Told what happens, in single lines."""


def _analysed(run: Run, say: Say) -> Analysis:
    """Analyse a run, or a part of a bag."""
    found = Analysis.of(run, ProgressBar("computing"))
    part = f"part {run.part} of {len(run.parts)}: " if run.parts else ""
    say(f"{part}computed the figures of {found.metrics.ticks} ticks in {len(found.phases)} phases")
    return found


def _read(bag: Path, say: Say, *, extensions: bool = False) -> tuple[Run, ...]:
    """Return the parts of a run folder, a bag folder or an .mcap file; raises LexstackError.

    A bag may come from anybody, so the modules that its scenario lists are imported only on demand.
    """
    runs = read_parts(bag, ProgressBar("reading"), plans=False)
    last = runs[-1]
    if extensions:
        load_extensions(last.resolved.scenario)
    for name, stack in last.resolved.stacks.items():
        types = {task.type for level in stack.levels for task in level.tasks}
        if types - TASKS.keys():
            absent = ", ".join(sorted(types - TASKS.keys()))
            say(f"left out: levels of {name}, for want of {absent}; --extensions may bring them")
    total = sum(sum(run.messages.values()) for run in runs)
    topics = {topic for run in runs for topic in run.messages}
    cut = "" if last.complete else "; the file ends before its end"
    say(f"read {total} messages of {len(topics)} topics from {last.path.name}{cut}")
    if len(runs) > 1:
        say(f"the plant was reset: the bag has {len(runs)} parts, {', '.join(_states(runs))}")
    return runs


def _states(runs: Sequence[Run]) -> list[str]:
    """Return how many states of the plant each part has, in words."""
    return [f"part {number}: {len(run.plant.tick)} states" for number, run in enumerate(runs, 1)]


def analyze(bag: Path, out: Path | None = None, progress: Say = lambda _line: None) -> Metrics:
    """Analyse a bag and write ``metrics.json`` and ``report.html``.

    Args:
        bag: a run folder, a bag folder or an .mcap file.
        out: where to write; default: the run folder, beside the bag folder.
        progress: told what happens, in single lines.

    Returns:
        The figures that were written; of a bag with resets those of the last part.

    Raises:
        BagError: the bag cannot be read, or the results cannot be written.
    """
    runs = _read(bag, progress)
    return _write_parts(runs, out or run_folder(runs[-1].path), progress).metrics


def _write_parts(runs: Sequence[Run], folder: Path, say: Say) -> Analysis:
    """Write the files of all parts of a bag; return the analysis of the last one."""
    for number, run in enumerate(runs[:-1], 1):
        if number > _MOST_PARTS:
            say(f"left out: parts {number} to {len(runs) - 1}, of more than {_MOST_PARTS} parts")
            break
        write(_analysed(run, say), folder / f"part-{number}", say)
    last = _analysed(runs[-1], say)
    write(last, folder, say)
    return last


def write(analysis: Analysis, folder: Path, say: Say) -> None:
    """Write ``metrics.json`` and ``report.html``; raises BagError."""
    run, metrics = analysis.run, analysis.metrics
    report = folder / "report.html"
    with writing(folder, make=True):
        (folder / "metrics.json").write_text(metrics.to_json(), encoding="utf-8")
        write_report(report, run, analysis.time_series, analysis.phases, metrics, say)
    say(f"wrote {folder / 'metrics.json'} and {report}")


def compare(
    first: Path, second: Path, out: Path | None, say: Say, *, extensions: bool = False
) -> Comparison:
    """Write ``comparison.json`` and ``.html`` of two bags; return it; raises LexstackError.

    Args:
        first: a run folder, a bag folder or an .mcap file.
        second: the same.
        out: where to write; default: the run folder of the second.
        say: told what happens.
        extensions: whether the modules that the bags' scenarios list may be imported.
    """
    runs = (_read(bag, say, extensions=extensions)[-1] for bag in (first, second))
    one, other = (_analysed(run, say) for run in runs)
    comparison = compare_metrics(one.metrics, other.metrics, (str(first), str(second)))
    folder = out or run_folder(other.run.path)
    with writing(folder, make=True):
        (folder / "comparison.json").write_text(comparison.to_json(), encoding="utf-8")
        write_comparison(folder / "comparison.html", (one, other), comparison)
    say(f"wrote {folder / 'comparison.json'} and {folder / 'comparison.html'}")
    return comparison


def run_folder(file: Path) -> Path:
    """Return the run folder of an .mcap file; a file on its own keeps its results beside it."""
    bag = file.resolve().parent
    return bag.parent if bag.name == "bag" or (bag / "metadata.yaml").is_file() else bag


def printable(line: str) -> str:
    """Return a line for a terminal: names from a bag shall not steer it."""
    return "".join(letter if letter.isprintable() else "?" for letter in line)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    options = parser().parse_args(arguments)
    try:
        return _run(options, lambda line: print(printable(line), flush=True))
    except LexstackError as error:
        print(printable(f"analyze: {error}"), file=sys.stderr)
        return BAD_ARGUMENT
    except KeyboardInterrupt:
        print("analyze: interrupted", file=sys.stderr)
        return INTERRUPTED


def _run(options: argparse.Namespace, say: Say) -> int:
    """Do what the arguments ask for."""
    if options.other is not None:
        if options.csv or options.parquet or options.video:
            raise BagError("--csv, --parquet, --video: of one bag at a time")
        comparison = compare(
            options.bag, options.other, options.out, say, extensions=options.extensions
        )
        print("\n" + "\n".join(map(printable, difference_lines(comparison))))
        return 0
    runs = _read(options.bag, say, extensions=options.extensions)
    folder = options.out or run_folder(runs[-1].path)
    analysis = _write_parts(runs, folder, say)
    for tables, export in ((options.csv, write_csv), (options.parquet, write_parquet)):
        if tables is not None:
            bar = ProgressBar("writing tables")
            paths = export(tables, analysis.run, analysis.time_series, bar)
            say(f"wrote {', '.join(path.name for path in paths)} to {tables}")
    if options.video:
        bar = ProgressBar("rendering")
        film = folder / "video.mp4"
        count = write_video(film, analysis.run, analysis.time_series, analysis.phases, bar)
        say(f"wrote {film}: {count} pictures")
    print("\n" + "\n".join(map(printable, summary_lines(analysis.metrics))))
    return 0


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = argparse.ArgumentParser(prog="./scripts/analyze", description=__doc__)
    result.add_argument("bag", type=Path, help="run folder, bag folder or .mcap file")
    result.add_argument("other", type=Path, nargs="?", help="a second one to compare with")
    result.add_argument(
        "--out", type=Path, metavar="DIR", help="where to write (default: the run folder)"
    )
    result.add_argument("--csv", type=Path, metavar="DIR", help="write tables as CSV, with units")
    result.add_argument(
        "--parquet", type=Path, metavar="DIR", help="write the same tables as Parquet, for pandas"
    )
    result.add_argument(
        "--extensions",
        action="store_true",
        help="import the modules that the scenario lists, for tasks that they bring; only of a bag "
        "that you trust",
    )
    result.add_argument(
        "--video", action="store_true", help="render video.mp4 too, offscreen: takes a while"
    )
    return result


if __name__ == "__main__":
    sys.exit(main())
