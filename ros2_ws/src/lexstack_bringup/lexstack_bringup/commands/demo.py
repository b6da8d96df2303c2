"""``scripts/demo``: a whole run through all processes, its bag, and its report."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from types import FrameType

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from lexstack.errors import ConfigurationError, LexstackError
from lexstack.options import shown
from lexstack_bag.commands.analyze import analyze, printable
from lexstack_bag.figures.goals import summary_lines
from lexstack_bag.storage.folders import empty_folder
from lexstack_bringup.domain import own_domain
from lexstack_bringup.live_page import Views, add_view_arguments
from lexstack_bringup.naming import Naming, add_naming_arguments
from lexstack_bringup.player import PLAYER, Player
from lexstack_bringup.processes import ADAPTER, PLAIN, RECORDER, bring_up
from lexstack_bringup.real_plant import RealPlant, real_plant, robots_domain
from lexstack_bringup.supervisor import Supervisor
from lexstack_config.available import FOR_OTHERS
from lexstack_config.checked import checked
from lexstack_config.own_folder import own_config, own_root
from lexstack_config.resolved import ResolvedScenario, load_scenario
from lexstack_interfaces.msg import TransitionStatus
from lexstack_ros.messages.names import PAGE
from lexstack_ros.recorder.options import add_recording_arguments, recorder_parameters

_DEFAULT = "transition-sequence"
_SLOWEST = 30.0  # wall seconds per simulated second after which a run counts as stuck
_PERIOD = 0.5  # s between two progress lines


class InterruptError(Exception):
    """SIGINT or SIGTERM came."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns 0, 1 where the run failed, 2 for bad arguments, 130 for Ctrl-C."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    root, config = own_root(), own_config()
    try:
        options = _parser(config).parse_args(arguments)
        resolved = resolve_scenario(config, options)
        options.real = real_plant(root, options, resolved)
        if options.real is not None:
            resolved = options.real.applied(resolved)
        recording, naming = recorder_parameters(options), Naming.of(options)
        views = Views.of(options)
        out = run_folder(root, options.out, resolved.scenario.name)
    except ConfigurationError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    try:
        return _run(resolved, out, recording, naming, views, real=options.real)
    except LexstackError as error:
        print(f"\nerror: {error}\nlogs: {out / 'logs'}", file=sys.stderr)
        return 1
    except InterruptError:
        print(f"\ninterrupted; ./scripts/analyze {out} shows what was recorded", file=sys.stderr)
        return 130


def _parser(config: Path) -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(
        prog="./scripts/demo",
        description="Run a scenario through all processes: simulation, controller, solver, "
        "recorder; then analyse its bag.",
    )
    add_run_arguments(parser, config)
    add_view_arguments(parser)
    parser.add_argument(
        "--plant",
        metavar="FILE",
        help="robots of your own in place of the simulation: a plant file, or a name in "
        "config/plants",
    )
    parser.add_argument(
        "--enable", action="store_true", help="with --plant: enable the robots at once; they move"
    )
    add_recording_arguments(parser)
    return parser


def add_run_arguments(parser: argparse.ArgumentParser, config: Path) -> None:
    """Add what says which run: scenario, folder, mode, seed."""
    add_scenario_arguments(parser, config)
    parser.add_argument("--out", type=Path, help="run folder (default: runs/SCENARIO-TIME)")
    parser.add_argument(
        "--mode",
        choices=("lockstep", "realtime"),
        help="lockstep: every tick waits for its command, reproducible; realtime: the wall's clock",
    )
    parser.add_argument("--seed", type=int, help="of everything random in the plant")
    add_naming_arguments(parser)


def add_scenario_arguments(parser: argparse.ArgumentParser, config: Path) -> None:
    """Add what says which scenario, and where its files are."""
    known = ", ".join(_scenarios(config))
    parser.add_argument(
        "scenario",
        nargs="?",
        default=_DEFAULT,
        help=f"one of: {known}; or a file (default: %(default)s)",
    )
    parser.add_argument(
        "--config",
        type=Path,
        action="append",
        default=[],
        metavar="FOLDER",
        help="a folder of your own robots, stacks and htmpc parameters, searched before the "
        "scenario's folder and lexstack's config (may be given again)",
    )


def _scenarios(config: Path) -> list[str]:
    """Return the names of the configured scenarios."""
    return sorted(path.stem for path in (config / "scenarios").glob("*.yaml"))


def resolve_scenario(config: Path, options: argparse.Namespace) -> ResolvedScenario:
    """Return the scenario with the command line's values put in, checked with all that it names.

    What is wrong shows here, before a folder is made or a process started.

    Raises:
        ConfigurationError: something is wrong; the text names file and key.
    """
    resolved = named_scenario(config, options)
    scenario = resolved.scenario
    if options.seed is not None and not 0 <= options.seed < 2**31:
        raise ConfigurationError(f"--seed: must be in [0, 2^31), got {options.seed}")
    return replace(
        resolved,
        scenario=replace(
            scenario,
            mode=options.mode or scenario.mode,
            seed=scenario.seed if options.seed is None else options.seed,
        ),
    )


def named_scenario(config: Path, options: argparse.Namespace) -> ResolvedScenario:
    """Return the scenario that the command line names, as ``resolve_scenario``."""
    for folder in options.config:
        if not folder.is_dir():
            raise ConfigurationError(f"--config: there is no folder {shown(str(folder))}")
    named = [each / "scenarios" / f"{options.scenario}.yaml" for each in (*options.config, config)]
    path = next((each for each in (*named, Path(options.scenario)) if is_file(each)), None)
    if path is None:
        known = ", ".join(_scenarios(config))
        raise ConfigurationError(f"unknown scenario {shown(options.scenario)}; known: {known}")
    first = options.config
    return checked(load_scenario(path, config, first), config, path, first)


def tell_unfit(resolved: ResolvedScenario) -> None:
    """Print which stack files are wrong for any robots; those made for others are no news."""
    for name, reason in resolved.unfit.items():
        if not reason.startswith(FOR_OTHERS):
            print(f"note: stack {name!r} cannot be asked for in this run: {reason}")


def is_file(path: Path) -> bool:
    """Return whether a file is there; a name that cannot be one's is none."""
    try:
        return path.is_file()
    except OSError:
        return False


def run_folder(root: Path, out: Path | None, scenario: str) -> Path:
    """Create the run's folder; raises ConfigurationError where it holds something already."""
    if out is None:
        stamp = datetime.now().strftime("%Y%m%d-%H%M%S")
        out = root / "runs" / f"{scenario}-{stamp}"
    return empty_folder(out)


def _run(
    resolved: ResolvedScenario,
    out: Path,
    recording: Mapping[str, str],
    naming: Naming,
    views: Views,
    *,
    real: RealPlant | None = None,
) -> int:
    """Bring up, play, end, analyse; returns the exit code."""
    scenario = resolved.scenario
    (out / "scenario.yaml").write_text(resolved.to_yaml(), encoding="utf-8")
    with own_domain() if real is None else nullcontext(robots_domain()) as domain:
        print(
            f"scenario {scenario.name}: {scenario.duration:g} s, {scenario.mode}, "
            f"{scenario.rate:g} Hz, seed {scenario.seed}\n"
            f"to listen from another terminal: export ROS_DOMAIN_ID={domain}"
        )
        tell_unfit(resolved)
        environment = {"ROS_DOMAIN_ID": str(domain)}
        os.environ.update(environment)
        supervisor = Supervisor(out / "logs", environment)
        try:
            _play(resolved, supervisor, out, recording, naming, views, real=real)
        finally:
            # From here on a second Ctrl-C changes nothing: all ends in order.
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)
            killed = supervisor.end()
    if killed:
        print(f"warning: had to be killed: {', '.join(killed)}", file=sys.stderr)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    metrics = analyze(out / "bag", out, print)
    print("\n" + "\n".join(map(printable, summary_lines(metrics))))
    return 0


def _play(
    resolved: ResolvedScenario,
    supervisor: Supervisor,
    out: Path,
    recording: Mapping[str, str],
    naming: Naming,
    views: Views,
    *,
    real: RealPlant | None = None,
) -> None:
    """Bring up the processes and play the scenario, with a line of progress."""
    with player_of(resolved, naming, real) as player:
        path, bag = out / "scenario.yaml", out / "bag"
        views.start(supervisor, path, naming)
        more = {RECORDER: recording}
        if real is not None:
            more[ADAPTER] = {"plant": str(real.path)}
        bring_up(supervisor, path, bag, peers=[PLAYER], more=more, naming=naming)
        play_shown(resolved, player, supervisor)


@contextmanager
def player_of(
    resolved: ResolvedScenario, naming: Naming = PLAIN, real: RealPlant | None = None
) -> Iterator[Player]:
    """Yield the player of a scenario, a node of this process."""
    rclpy.init(args=["--ros-args", *naming.rules], signal_handler_options=SignalHandlerOptions.NO)
    executor = EventsExecutor()
    enable = real is None or real.enable
    player = Player(resolved, executor, simulated=real is None, enable=enable)
    try:
        yield player
    finally:
        executor.shutdown()
        player.destroy_node()
        rclpy.try_shutdown()


def play_shown(resolved: ResolvedScenario, player: Player, supervisor: Supervisor) -> None:
    """Play the scenario with a line of progress; raises LexstackError where it cannot go on."""
    progress = _Progress(resolved, player)

    def watch() -> None:
        supervisor.check([PAGE])  # a run goes on without its page
        progress.show()

    player.play(watch, 60.0 + _SLOWEST * resolved.scenario.duration)
    progress.show(last=True)


class _Progress:
    """Where the run stands: one line, rewritten on a terminal."""

    def __init__(self, resolved: ResolvedScenario, player: Player) -> None:
        """Watch a player."""
        self._scenario = resolved.scenario
        self._player = player
        self._begun = self._shown = time.monotonic()

    def show(self, *, last: bool = False) -> None:
        """Print, if it is time to."""
        now = time.monotonic()
        if not last and now - self._shown < (_PERIOD if sys.stdout.isatty() else 10 * _PERIOD):
            return
        self._shown = now
        tick, status = self._player.tick, self._player.transition
        where = "" if status is None else _where(status)
        line = (
            f"  {tick / self._scenario.rate:6.2f} of {self._scenario.duration:g} s  "
            f"{tick / (now - self._begun):4.0f} ticks/s  {where:<40}"
        )
        print(line, end="\r" if sys.stdout.isatty() and not last else "\n", flush=True)


def _where(status: TransitionStatus) -> str:
    """Return the stack in effect and how far a switch to it is, or the next one."""
    if status.phase in (TransitionStatus.REQUESTED, TransitionStatus.PREPARING):
        return f"next: {status.to_stack}"
    return f"{status.to_stack}, alpha {status.alpha:.2f}"


def interrupt(_number: int, _frame: FrameType | None) -> None:
    """Turn a signal into an exception of the main thread."""
    raise InterruptError


if __name__ == "__main__":
    sys.exit(main())
