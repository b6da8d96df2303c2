"""What the distribution saves, T Fig. 9: controller and solver in a process each, or both in one.

The paper's sequence with ``at_end: stay``, as in T: from (A) on the controller follows the solver
at every tick. The ideal plant; a pipe between the processes, so the delay of ROS messages is not in
it. Before every tick the controller sleeps, as it does while a plant moves: a process that never
rests is faster than any real one, its caches are warm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, process_time, sleep

import numpy as np

from lexstack.transition import Source, alpha
from lexstack.types import Vector
from lexstack_config.parts import build_team
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.measuring import no_collection, p50_p99
from lexstack_experiments.pictures import picture
from lexstack_experiments.remote import RemoteB
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table
from lexstack_experiments.runs import changed, scenario_of, with_method

NAME = "computation"
SWITCHES = 3
_SPACING = 4.0  # s from switch to switch: the times do not need the robots to settle
_REST = 1e-3  # s of sleep before a tick
_US = 1e6

_COLUMNS = ("", "us p50", "us p99", "CPU share %")
_NOTES = (
    "Ticks at which the controller follows the solver. CPU share: of one core at the scenario's",
    "rate, of the process. Wall: from the state to the command, with pipe and waiting.",
    "'the solver one tick behind': the controller takes its",
    "chi of the tick before, as in realtime, so that both work at the same time.",
)


@dataclass(frozen=True, slots=True)
class Times:
    """The times of a closed loop at the ticks at which the controller follows the solver [s].

    Attributes:
        a: of the controller's tick.
        b: of the solver's solve.
        wall: from the state to the command, the solver's part and the waiting for it included.
        cpu: of the controller's process.
        cpu_b: of the solver's process, empty where it has none.
    """

    a: Vector
    b: Vector
    wall: Vector
    cpu: Vector
    cpu_b: Vector


def run(options: Options) -> Results:
    """Run the sequence in one process and in two, and compare."""
    resolved = _sequence(options)
    one = _together(resolved)
    options.say(f"the controller and the solver in one process: {one.a.size} ticks")
    two = _apart(resolved)
    options.say(
        "the controller and the solver in two processes, the controller waits for the solver"
    )
    behind = _apart(changed(resolved, mode="realtime"), behind=True)
    options.say("the controller and the solver in two processes at the same time")
    draw(_alphas(resolved), one, two, options.out / "fig9.png")
    rate = resolved.scenario.rate
    return options.results(
        NAME,
        _figures(one, two, behind),
        Table(_COLUMNS, _rows(one, two, behind, rate)),
        {"plant": "ideal", "rate_hz": rate, "at_end": "stay", "between": "pipe", "rest_s": _REST},
        _NOTES,
    )


def _sequence(options: Options) -> ResolvedScenario:
    """Return the first switches of the sequence, closer together; the solver is then followed."""
    resolved = with_method(scenario_of(options.config), "bridge", at_end="stay")
    events = tuple(
        replace(event, at=1.0 + i * _SPACING)
        for i, event in enumerate(resolved.scenario.events[: options.cases])
    )
    return changed(resolved, events=events, duration=1.0 + _SPACING * options.cases)


def _together(resolved: ResolvedScenario) -> Times:
    """Return the times of the controller and the solver in one process, one after the other."""
    loop = _loop(resolved)
    times = _timed(loop)
    return replace(times, b=np.array(list(loop.record.b_times.values())))


def _apart(resolved: ResolvedScenario, *, behind: bool = False) -> Times:
    """Return the times of the controller in this process and the solver in another."""
    loop = _loop(resolved)
    with RemoteB(resolved, behind=behind) as remote:
        loop.ask_solver = remote.ask
        times = _timed(loop)
    efforts = remote.efforts
    walls, cpus = (np.array([getattr(e, name) for e in efforts]) for name in ("wall", "cpu"))
    return replace(times, b=walls, cpu_b=cpus)


def _loop(resolved: ResolvedScenario) -> Loop:
    """Return a closed loop in the ideal plant."""
    return Loop(resolved, IdealPlant(resolved, build_team(resolved)))


def _timed(loop: Loop) -> Times:
    """Run a loop to its end, garbage collection off, and return the controller's times."""
    scenario = loop.resolved.scenario
    rows = []
    with no_collection():
        for _ in range(round(scenario.duration * scenario.rate)):
            sleep(_REST)
            begun, used = perf_counter(), process_time()
            command = loop.step()
            wall, cpu = perf_counter() - begun, process_time() - used
            if command.transition.source is Source.SOLVER:
                rows.append((command.solve_time, wall, cpu))
    a, wall, cpu = np.array(rows).T
    return Times(a, np.empty(0), wall, cpu, np.empty(0))


def _figures(one: Times, two: Times, behind: Times) -> list[Figure]:
    """Return how the parts compare with the whole."""
    both = one.a + one.b
    figures = []
    for name, part in (("A", two.a), ("B", two.b)):
        for words, percent in (("p50", 50), ("p99", 99)):
            whole = _US * float(np.percentile(both, percent))
            figures.append(
                Figure(
                    f"dt_{name} against dt_C, {words}",
                    _US * float(np.percentile(part, percent)) / whole,
                    "x",
                    Goal("<=", 1.0),
                    paper="< 1 x by eye",
                )
            )
    wall = _US * float(np.median(behind.wall))
    peer = Peer("one process", _US * float(np.median(one.wall)))
    return [
        *figures,
        Figure("Wall time of a tick, the solver one tick behind, p50", wall, "us", peer=peer),
    ]


def _rows(one: Times, two: Times, behind: Times, rate: float) -> list[tuple[Cell, ...]]:
    """Return the rows of the table."""

    def row(name: str, times: Vector, cpu: Vector | None) -> tuple[Cell, ...]:
        share = None if cpu is None else 100.0 * rate * float(np.mean(cpu))
        return (name, *p50_p99(_US * times), share)

    return [
        row("dt_A, own process", two.a, two.cpu),
        row("dt_B, own process", two.b, two.cpu_b),
        row("dt_C, both in one", one.a + one.b, one.cpu),
        row("wall, one process", one.wall, None),
        row("wall, two processes", two.wall, None),
        row("wall, two, the solver one tick behind", behind.wall, None),
    ]


def _alphas(resolved: ResolvedScenario) -> list[tuple[float, float]]:
    """Return time since the trigger [s] and alpha of the first transition."""
    config, rate = resolved.scenario.transition, resolved.scenario.rate
    times = np.arange(0.0, config.duration + 0.5 / rate, 1.0 / rate)
    return [(float(t), alpha(config.profile, float(t), config.duration)) for t in times]


def draw(alphas: list[tuple[float, float]], one: Times, two: Times, path: Path) -> None:
    """Write the three times as boxes over all ticks, and alpha, T Fig. 9."""
    with picture(path, 1, 2, (7.0, 2.8)) as axes:
        values = [_US * two.a, _US * two.b, _US * (one.a + one.b)]
        names = ("Δt_A", "Δt_B", "Δt_C")
        axes[0].boxplot(values, whis=(1, 99), showfliers=False, tick_labels=names)
        axes[0].set_ylim(bottom=0.0)
        axes[0].set_title("time of a tick [µs], whiskers 1 % and 99 %", loc="left")
        axes[1].plot(*zip(*alphas, strict=True))
        axes[1].set_title("α over the time since the switch [s]", loc="left")


EXPERIMENT = Experiment(
    "controller and solver in two processes or one, T Fig. 9", "switches", SWITCHES, run
)
