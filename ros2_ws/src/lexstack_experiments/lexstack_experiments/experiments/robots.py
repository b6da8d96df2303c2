"""N robots change their stack, all at once or one by one: what a tick costs, and that chi is right.

One by one, every robot is on a transition of its own, with its own alpha, and all of them are
under way at the same time. The scenarios are made in memory: the robots stand on a grid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import thread_time

import numpy as np
from numpy.typing import NDArray

from lexstack.hqp import SOLVERS, HqpProblem, HqpSolver, Solution, make_solver
from lexstack.transition import Phase
from lexstack.types import Vector
from lexstack_config.parts import Parts, build_controller, build_team
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig, PlacementConfig
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.pictures import picture
from lexstack_experiments.probes import WatchedSolver
from lexstack_experiments.replay import Tape
from lexstack_experiments.results import AT_MOST_ONE, Cell, Figure, Goal, Results, Table, zero
from lexstack_experiments.runs import changed, scenario_of

NAME = "robots"
SIZES = (2, 4, 8, 16, 32)
WAYS = ("at once", "one by one")
_STACK = "reach_base"
_SPACING = 3.0  # m from base to base
_BLEND = 0.6  # s
_FIRST, _LAST = 0.1, 0.4  # s, between which the switches are asked for, one by one
_DURATION = 1.4  # s
_PASSES = 5
_GOALS = {8: 4.5, 32: 20.0}  # times the cost of two robots
_SAME = 1e-6  # m/s, rad/s
_EVERY = 20  # ticks from one comparison with the dense solution to the next
_US = 1e6

_NOTES = (
    "CPU time of a tick, the fastest pass of each tick. idle, blending: median over the",
    "ticks before the first switch, and over those at which all robots are in a blend; x 2 robots:",
    "that of blending over two robots; off dense: chi from the optimum of all joints solved",
    f"together, without clusters, at every {_EVERY}th tick; acc. ratio: peak over the limit.",
)

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Case:
    """A number of robots and a way to switch them, played once.

    Attributes:
        count: of the robots.
        way: how they switch.
        tape: the closed loop, to be replayed.
        apart: largest difference from the dense solution, m/s and rad/s.
        channels: the most that there were at a time.
        adopted: robots that have adopted the stack at the end.
        peak: of the acceleration over its limit.
        blending: the ticks at which all robots are in a blend.
    """

    count: int
    way: str
    tape: Tape
    apart: float
    channels: int
    adopted: int
    peak: float
    blending: Mask


class DenseCheck:
    """Now and then holds a chi against one solve of all joints.

    Attributes:
        apart: largest difference so far, m/s and rad/s.
    """

    def __init__(self, name: str) -> None:
        """Check the solver of this name."""
        self.apart = 0.0
        self._dense = SOLVERS[name]()
        self._count = 0

    def __call__(self, problem: HqpProblem, solution: Solution) -> None:
        """Look at what was solved."""
        if self._count % _EVERY == 0:
            apart = np.abs(solution.chi - self._dense.solve(problem).chi)
            self.apart = max(self.apart, float(apart.max()))
        self._count += 1


def run(options: Options) -> Results:
    """Play all sizes in both ways, then replay them in turns."""
    base = scenario_of(options.config)
    sizes = SIZES[: options.cases]
    cases = []
    for count in sizes:
        cases += [played(base, count, way) for way in WAYS]
        options.say(f"{count} robots: played at once and one by one")
    times: dict[tuple[int, str], list[Vector]] = {(c.count, c.way): [] for c in cases}
    for number in range(_PASSES + 1):
        for case in cases:
            controller = build_controller(case.tape.resolved, Parts.of(case.tape.resolved))
            spent, _ = case.tape.play(controller, clock=thread_time)
            if number:  # the first pass warms up
                times[case.count, case.way].append(_US * spent)
        options.say(f"pass {number} of {_PASSES}")
    measured = [np.array(times[case.count, case.way]) for case in cases]
    two = {c.way: _busy(c, m) for c, m in zip(cases[:2], measured[:2], strict=True)}
    rows = [_row(case, mine, two[case.way]) for case, mine in zip(cases, measured, strict=True)]
    draw(cases, rows, options.out / "robots.png")
    return options.results(
        NAME,
        _figures(cases, rows),
        Table.of(rows),
        {"plant": "ideal", "rate_hz": base.scenario.rate, "blend_s": _BLEND, "passes": _PASSES},
        _NOTES,
    )


def team_on_a_grid(base: ResolvedScenario, count: int, way: str) -> ResolvedScenario:
    """Return a short scenario for ``count`` robots of the first robot's kind on a grid."""
    model = next(iter(base.scenario.robots.values())).model
    names = [f"mover_{i + 1}" for i in range(count)]
    side = int(np.ceil(np.sqrt(count)))
    spots = [(_SPACING * (i % side), _SPACING * (i // side), 0.0) for i in range(count)]
    stack = base.stacks[_STACK]
    single = {
        f"{_STACK}_{name}": replace(stack, name=f"{_STACK}_{name}", robots=(name,))
        for name in names
    }
    if way == WAYS[0]:
        events = [EventConfig(at=_FIRST, switch=_STACK, duration=_BLEND)]
    else:
        times = np.round(np.linspace(_FIRST, _LAST, count), 2)
        events = [
            EventConfig(at=float(time), switch=name, duration=_BLEND)
            for time, name in zip(times, single, strict=True)
        ]
    kept = {name: base.stacks[name] for name in ("track", _STACK)}
    return changed(
        replace(base, stacks=kept | single),
        robots={
            name: PlacementConfig(model=model, base=spot)
            for name, spot in zip(names, spots, strict=True)
        },
        base_target={name: (x, y - 0.5, 0.0) for name, (x, y, _) in zip(names, spots, strict=True)},
        events=tuple(events),
        duration=_DURATION,
    )


def played(base: ResolvedScenario, count: int, way: str) -> Case:
    """Return a case, played in the ideal plant."""
    resolved = team_on_a_grid(base, count, way)
    checks: list[DenseCheck] = []

    def solver() -> HqpSolver:
        checks.append(DenseCheck(resolved.scenario.solver))
        return WatchedSolver(make_solver(resolved.scenario.solver), checks[-1])

    parts = Parts.of(resolved)
    controller = build_controller(resolved, parts, solver)
    loop = Loop(resolved, IdealPlant(resolved, parts.team), controller)
    tape = Tape.of_loop(loop)
    commands = tape.commands
    chi = np.array([command.chi for command in commands])
    steps = np.diff(chi, axis=0) / (parts.dt * parts.team.limits.acceleration)
    wanted = {Phase.BLENDING}
    return Case(
        count,
        way,
        tape,
        max(check.apart for check in checks),
        max(len(command.transitions) for command in commands),
        _adopted(commands[-1].transitions),
        float(np.abs(steps).max()),
        np.array([{state.phase for state in c.transitions} == wanted for c in commands]),
    )


def _adopted(states: tuple) -> int:
    """Return how many robots serve the new stack."""
    return sum(
        len(state.robots)
        for state in states
        if state.phase is Phase.IDLE and state.to_stack.startswith(_STACK)
    )


def _busy(case: Case, times: NDArray[np.float64]) -> float:
    """Return the time of a tick while all robots blend [us]; ``times`` of shape (passes, ticks)."""
    return float(np.median(times.min(axis=0)[case.blending]))


def _row(case: Case, mine: NDArray[np.float64], two: float) -> dict[str, Cell]:
    """Return a line of the table; ``mine`` of shape (passes, ticks), ``two``: two robots' [us]."""
    first = round(_FIRST * case.tape.resolved.scenario.rate)
    quiet, middle = mine.min(axis=0), _busy(case, mine)
    return {
        "robots": case.count,
        "switch": case.way,
        "channels": case.channels,
        "idle us": float(np.median(quiet[1:first])),
        "blending us": middle,
        "x 2 robots": middle / two,
        "us per robot": middle / case.count,
        "off dense": case.apart,
        "acc. ratio": case.peak,
        "adopted": case.adopted,
    }


def _figures(cases: list[Case], rows: list[dict[str, Cell]]) -> list[Figure]:
    """Return the figures to reach."""
    found = {(row["robots"], row["switch"]): row for row in rows}
    figures = []
    for count, limit in _GOALS.items():
        for way in WAYS:
            row = found.get((count, way))
            ratio = None if row is None else float(row["x 2 robots"] or 0.0)
            title = f"Tick of {count} robots over that of 2, {way}"
            figures.append(Figure(title, ratio, "x", Goal("<=", limit)))
    left = sum(case.count - case.adopted for case in cases)
    return [
        *figures,
        Figure(
            "chi off the dense solution",
            max(case.apart for case in cases),
            "m/s, rad/s",
            Goal("<=", _SAME),
        ),
        Figure("Largest acceleration / limit", max(c.peak for c in cases), "", AT_MOST_ONE),
        zero("Robots that have not adopted their stack", left),
    ]


def draw(cases: list[Case], rows: list[dict[str, Cell]], path: Path) -> None:
    """Write the cost over the number of robots, and alpha of every channel one by one."""
    with picture(path, 1, 2, (8.0, 3.0)) as axes:
        for way in WAYS:
            points = [(r["robots"], r["blending us"]) for r in rows if r["switch"] == way]
            axes[0].plot(*zip(*points, strict=True), "o-", label=f"switch {way}")
        counts = sorted({case.count for case in cases})
        start = next(float(r["blending us"] or 0.0) for r in rows if r["switch"] == WAYS[0])
        axes[0].plot(
            counts, [start * c / counts[0] for c in counts], ":", color="#555555", label="linear"
        )
        axes[0].set_xscale("log", base=2)
        axes[0].set_yscale("log")
        axes[0].set_xticks(counts, [str(count) for count in counts])
        axes[0].set_title("time of a tick [µs] over robots", loc="left")
        axes[0].legend()
        _draw_alphas(next(c for c in cases[::-1] if c.way == WAYS[1]), axes[1].plot)
        axes[1].set_title("α of every robot, one by one, over time [s]", loc="left")


def _draw_alphas(case: Case, plot: Callable[..., object]) -> None:
    """Draw alpha of every robot that is in a blend."""
    team = build_team(case.tape.resolved)
    for name in team.names:
        points = [
            (command.stamp, state.alpha)
            for command in case.tape.commands
            for state in command.transitions
            if name in state.robots and state.phase in (Phase.BLENDING, Phase.ADOPTING)
        ]
        plot(*zip(*points, strict=True), linewidth=0.8)


EXPERIMENT = Experiment("N robots switch at once and one by one", "sizes", len(SIZES), run)
