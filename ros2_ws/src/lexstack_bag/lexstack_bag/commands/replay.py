"""Replays a bag: recorded states, references and requests go through the same library code again.

Without changes each chi must be the recorded one, bit by bit: the first tick that is not, is told.
With changes it answers what the nodes would have done at the recorded states: the motion stays the
recorded one (open loop), the differences are drawn and summed up.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from lexstack.errors import LexstackError
from lexstack_bag.commands.analyze import run_folder
from lexstack_bag.errors import BagError
from lexstack_bag.progress import ProgressBar
from lexstack_bag.replay.changes import Changes, Question
from lexstack_bag.replay.nodes import REPLAYERS, recorded_nodes
from lexstack_bag.replay.outcome import Outcome
from lexstack_bag.replay.planner import PLANNER
from lexstack_bag.run.reader import read_run
from lexstack_bag.run.run import Run
from lexstack_bag.run.wholeness import other_parts
from lexstack_bag.storage.folders import writing

DIFFERENT, BAD_ARGUMENT, INTERRUPTED = 1, 2, 130


def replay(bag: Path, changes: Changes, nodes: Sequence[str] = ()) -> tuple[Run, list[Outcome]]:
    """Replay nodes of a bag.

    Args:
        bag: a run folder, a bag folder or an .mcap file.
        changes: what shall be other than it was.
        nodes: keys of REPLAYERS; empty: all that have a chi or plans in the bag.

    Raises:
        BagError: the bag cannot be read; ConfigurationError: a change makes no sense.
    """
    run = read_run(bag, ProgressBar("reading"))
    resolved = changes.applied(run.resolved)
    outcomes, recorded = [], recorded_nodes(run)
    for node in nodes or recorded:
        if node not in recorded:
            what = "plan" if node == PLANNER else "chi"
            raise BagError(f"{bag}: holds no {what} of {node}")
        bar = ProgressBar(f"replaying {node}")
        outcomes.append(REPLAYERS[node](Question(run, changes, resolved, bar)))
    if not outcomes:
        raise BagError(f"{bag}: holds no chi of {' or '.join(REPLAYERS)}")
    return run, outcomes


def write(folder: Path, outcomes: Sequence[Outcome], changes: Changes, run: Run) -> list[Path]:
    """Write ``replay.json`` and ``replay.png`` and return them; raises BagError."""
    from lexstack_bag.replay.picture import draw  # noqa: PLC0415  # slow to import

    content = {
        "bag": run.path.name,
        "changes": str(changes),
        "open_loop": True,
        "nodes": [outcome.plain() for outcome in outcomes],
    }
    figures, picture = folder / "replay.json", folder / "replay.png"
    title = f"{run.resolved.scenario.name}: {changes or 'no changes'} (open loop)"
    with writing(folder, make=True):
        figures.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")
        draw(outcomes, title, picture)
    return [figures, picture]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns:
        0: identical, or changes were asked for; 1: it differs without changes; 2: a bad argument
        or bag; 130: interrupted.
    """
    options = parser().parse_args(arguments)
    changes = Changes(tuple(options.set), options.method, options.stack, options.solver)
    try:
        run, outcomes = replay(options.bag, changes, options.node)
        for part in other_parts(run):
            print(f"the plant was reset: replayed part {run.part}, left out {part}")
        print("\n".join(outcome.line() for outcome in outcomes))
        if changes:
            print(f"with {changes}, at the recorded states (open loop)")
        if changes or options.out or not all(outcome.identical for outcome in outcomes):
            folder = options.out or run_folder(run.path) / "replay"
            paths = write(folder, outcomes, changes, run)
            print(f"wrote {' and '.join(str(path) for path in paths)}")
    except LexstackError as error:
        print(f"replay: {error}", file=sys.stderr)
        return BAD_ARGUMENT
    except KeyboardInterrupt:
        print("replay: interrupted", file=sys.stderr)
        return INTERRUPTED
    if changes or all(outcome.identical for outcome in outcomes):
        return 0
    if run.resolved.scenario.mode == "realtime":
        print("a realtime run need not repeat itself: who heard what at which tick is a guess")
    return DIFFERENT


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    result = argparse.ArgumentParser(
        prog="./scripts/replay",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="To play the bag to live nodes: ./scripts/replay BAG --publish --help; "
        "to look at it in a browser: ./scripts/replay BAG --view",
    )
    result.add_argument("bag", type=Path, help="run folder, bag folder or .mcap file")
    result.add_argument(
        "--node",
        action="append",
        choices=tuple(REPLAYERS),
        default=[],
        help="replay this node alone; may be given again (default: all that are in the bag)",
    )
    result.add_argument(
        "--set",
        action="append",
        metavar="KEY=VALUE",
        default=[],
        help="change a value, e.g. transition.duration=0.5 or "
        "stacks.track.levels.0.tasks.0.parameters.gain=5; may be given again",
    )
    result.add_argument("--method", default="", help="of all transitions")
    result.add_argument(
        "--stack",
        default="",
        metavar="NAME|OLD=NEW",
        help="send every switch to another stack, or those to OLD",
    )
    result.add_argument("--solver", default="", help="of all problems")
    result.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="where to write replay.json and replay.png (default: RUN/replay, where it differs)",
    )
    return result


if __name__ == "__main__":
    sys.exit(main())
