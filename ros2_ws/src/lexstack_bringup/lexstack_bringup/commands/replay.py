"""``scripts/replay``: a bag through the library again, to live nodes, or on a page."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from threading import Event

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from lexstack.errors import LexstackError
from lexstack_bag.commands import replay as core
from lexstack_bag.errors import BagError
from lexstack_bag.progress import ProgressBar
from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.order import in_lockstep
from lexstack_bag.replay.requests import requests_of
from lexstack_bag.run.reader import read_provenance, read_run
from lexstack_bag.storage.container import Container, by_log_time, find_files
from lexstack_bag.storage.decoder import Decoder
from lexstack_bag.storage.folders import writing
from lexstack_bag.storage.selection import Selection
from lexstack_bringup.bag_player import BagPlayer, paced
from lexstack_bringup.live_peer import LIVE

_NOBODY = "nobody"
_FASTEST = 1000.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code, see lexstack_bag.commands.replay."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    views = "--view" in given
    if not views and not any(word.partition("=")[0] == "--publish" for word in given):
        return core.main(given)
    try:
        return _view(given) if views else _publish(_parser().parse_args(given))
    except LexstackError as error:
        print(f"replay: {error}", file=sys.stderr)
        return core.BAD_ARGUMENT
    except KeyboardInterrupt:
        print("replay: interrupted", file=sys.stderr)
        return core.INTERRUPTED


def _parser() -> argparse.ArgumentParser:
    """Return the command line of --publish."""
    parser = argparse.ArgumentParser(
        prog="./scripts/replay BAG --publish",
        description="Play a bag over DDS. With a NODE, that node is live: what it published is "
        "left out, requests are made by service, every tick waits for its answer, and its chi is "
        "held against the recorded one.",
    )
    parser.add_argument("bag", type=Path, help="run folder, bag folder or .mcap file")
    parser.add_argument(
        "--publish",
        nargs="?",
        const=_NOBODY,
        choices=(*LIVE, _NOBODY),
        metavar="NODE",
        help=f"which node is live: {', '.join(LIVE)}; without: play all, wait for nobody",
    )
    parser.add_argument(
        "--rate",
        type=float,
        default=1.0,
        help="multiple of the recorded pace; 0: as fast as answers come (default: 1)",
    )
    parser.add_argument("--topics", nargs="+", default=[], help="play these topics")
    parser.add_argument("--regex", default="", help="play topics that contain this expression")
    parser.add_argument("--exclude-topics", nargs="+", default=[], help="leave these topics out")
    parser.add_argument("--exclude-regex", default="", help="leave out topics that contain this")
    parser.add_argument(
        "--patience", type=float, default=30.0, metavar="S", help="wall time to wait for an answer"
    )
    parser.add_argument(
        "--scenario", type=Path, metavar="FILE", help="write the bag's scenario there, and end"
    )
    return parser


def _view(arguments: Sequence[str]) -> int:
    """Show the bag on a page until Ctrl-C; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="./scripts/replay BAG --view",
        description="Show a bag in a browser, with a slider of time; Ctrl-C ends it.",
    )
    parser.add_argument("bag", type=Path, help="run folder, bag folder or .mcap file")
    parser.add_argument("--view", action="store_true", required=True)
    options = parser.parse_args(arguments)
    # viser and MuJoCo take a second to load.
    from lexstack_ros.view.page.bag import BagPage, run_page  # noqa: PLC0415
    from lexstack_ros.view.recorded import Recorded  # noqa: PLC0415

    run = read_run(options.bag, ProgressBar("reading"))
    page = BagPage(f"lexstack: {run.resolved.scenario.name}, recorded", Recorded(run))
    ended = Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    print(f"watch it at {page.url}", flush=True)
    run_page(page, ended)
    page.close()
    return 0


def _publish(options: argparse.Namespace) -> int:
    """Play the bag; returns the exit code."""
    if not 0.0 <= options.rate <= _FASTEST:
        raise BagError(f"--rate: must be in [0, {_FASTEST:g}], got {options.rate}")
    if not 0.0 < options.patience < float("inf"):
        raise BagError(f"--patience: must be a time > 0 in seconds, got {options.patience}")
    selection = Selection(
        tuple(options.topics), options.regex, tuple(options.exclude_topics), options.exclude_regex
    )
    container = Container(find_files(options.bag))
    if options.scenario is not None:
        return _write_scenario(container, options.scenario)
    read_provenance(container)  # the container knows the run's namespace from here on
    run = read_run(options.bag, ProgressBar("reading"))
    live = "" if options.publish == _NOBODY else options.publish
    if live and live not in run.chi:
        raise BagError(f"{options.bag}: holds no chi of {live}")
    total = sum(1 for _ in container.messages())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    executor = EventsExecutor()
    player = None
    try:
        player = BagPlayer(executor, container, selection, live, options.patience)
        print(f"plays {len(player.topics)} topics, {total} messages in the bag", flush=True)
        if live:
            print(
                f"waiting for {LIVE[live].node}; if it does not run yet:\n"
                f"  ./scripts/replay {options.bag} --publish --scenario scenario.yaml\n"
                f"  ./scripts/shell python -m {LIVE[live].command} --ros-args "
                "-p scenario:=scenario.yaml",
                flush=True,
            )
        player.wait_connected()
        user = requests_of(run, Changes(), run.resolved) if live == "robot_a" else []
        expected = set(run.chi[live].tick.tolist()) if live else set()
        again = Container(container.files, container.namespace)
        messages = by_log_time(again.messages(ProgressBar("playing")))
        if live and run.resolved.scenario.mode == "lockstep":
            messages = in_lockstep(messages, Decoder())
        played = player.play(messages, paced(options.rate), user, expected)
        print(f"played {played} messages")
        if player.peer is None:
            return 0
        outcome = player.peer.outcome(run)
        print(outcome.line())
        return 0 if outcome.identical else core.DIFFERENT
    finally:
        executor.shutdown()
        if player is not None:
            player.destroy_node()
        rclpy.try_shutdown()


def _write_scenario(container: Container, path: Path) -> int:
    """Write the scenario that a bag carries."""
    _, resolved = read_provenance(container)
    with writing(path):
        path.write_text(resolved.to_yaml(), encoding="utf-8")
    print(f"wrote {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
