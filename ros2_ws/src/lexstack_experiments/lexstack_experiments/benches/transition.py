"""A whole tick of the controller without ROS: kinematics, errors, bounds, HQP, transition.

The states and the solver's messages are those of the paper's sequence in closed loop, recorded once
in the ideal plant and then replayed; the replayed chi must be the recorded one. Times are of the
thread's clock, so that other programs' share is not in them, with garbage collection off. One pass
warms up.
Beside them stands, from the same run, the time of one singular value decomposition of a 20 x 20
matrix: it makes machines comparable.
"""

from __future__ import annotations

from time import perf_counter, thread_time

import numpy as np
from numpy.typing import NDArray

from lexstack.limits import viable_bounds
from lexstack.types import Vector
from lexstack_config.parts import Parts, build_controller
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.measuring import p50_p99
from lexstack_experiments.probes import Stopwatch, counting_controller, timed_parts
from lexstack_experiments.replay import Tape
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table
from lexstack_experiments.runs import scenario_of

NAME = "transition"
PASSES = 5
_GOALS = {"idle": 100.0, "blending": 130.0}  # us, of the median
_US = 1e6

_COLUMNS = ("stack", "state", "ticks", "us p50", "us p99", "us p50, quiet", "x SVD")
_SHARES = ("kinematics", "tasks", "bounds", "HQP", "transition and rest")
_NOTES = (
    "us p50, p99: over all ticks of all passes; quiet: median over the ticks of the fastest pass",
    "of each, what the code costs when nothing disturbs it; x SVD: p50 over one SVD of 20 x 20.",
)

Mask = NDArray[np.bool_]


def run(options: Options) -> Results:
    """Record the sequence, replay it, and say where the time goes."""
    resolved = scenario_of(options.config)
    tape = Tape.of(resolved)
    options.say(f"recorded {len(tape.states)} ticks of {resolved.scenario.name}")
    passes, units, difference = [], [], 0.0
    for number in range(options.cases + 1):
        times, apart = tape.play(build_controller(resolved, Parts.of(resolved)), clock=thread_time)
        difference = max(difference, apart)
        if number:
            passes.append(_US * times)
            units.append(_svd())
            options.say(f"pass {number} of {options.cases}: {np.median(passes[-1]):.0f} us p50")
    every, unit = np.array(passes), float(np.median(units))
    rows = _rows(tape)
    return options.results(
        NAME,
        (*_figures(every, rows), _same(difference), Figure("One SVD of 20 x 20, p50", unit, "us")),
        (
            Table(_COLUMNS, [_line(name, every[:, mask], unit) for name, mask in rows]),
            _profile(tape, rows),
        ),
        {"plant": "ideal", "rate_hz": resolved.scenario.rate, "robots": 2, "n": _n(tape)},
        _NOTES,
    )


Row = tuple[tuple[str, str], Mask]
"""The stack and whether the controller blends or is idle, and which ticks those are."""


def _rows(tape: Tape) -> list[Row]:
    """Return the rows of the table, in the order in which they occur."""
    keys = [
        (command.stack, "blending" if blending else "idle")
        for command, blending in zip(tape.commands, tape.blending, strict=True)
    ]
    return [(key, np.array([k == key for k in keys])) for key in dict.fromkeys(keys)]


def _figures(every: NDArray[np.float64], rows: list[Row]) -> list[Figure]:
    """Return the medians that have a goal."""
    return [
        Figure(
            f"{stack}, {state}: p50 of a tick",
            float(np.median(every[:, mask])),
            "us",
            Goal("<=", _GOALS[state]),
        )
        for (stack, state), mask in rows
    ]


def _line(name: tuple[str, str], times: NDArray[np.float64], unit: float) -> tuple[Cell, ...]:
    """Return a row of the main table; ``times`` of shape (passes, ticks) [us]."""
    middle, p99 = p50_p99(times)
    quiet = float(np.median(times.min(axis=0)))
    return (*name, times.shape[1], middle, p99, quiet, middle / unit)


def _same(difference: float) -> Figure:
    """Return whether the replay gives what was recorded."""
    return Figure("Replayed chi against recorded", difference, "m/s, rad/s", Goal("==", 0.0))


def _profile(tape: Tape, rows: list[Row]) -> Table:
    """Return where the time of a tick goes, in one more pass with clocks inside."""
    parts = Parts.of(tape.resolved)
    kinematics, tasks = Stopwatch(), Stopwatch()
    controller, tally = counting_controller(tape.resolved, timed_parts(parts, kinematics, tasks))
    sums = np.empty((len(tape.states), 3))

    def watch(tick: int) -> None:
        sums[tick] = kinematics.seconds, tasks.seconds, tally.seconds

    whole, _ = tape.play(controller, watch)
    spent = np.diff(sums, axis=0, prepend=np.zeros((1, 3)))
    bounds = _bounds(tape, parts)
    rest = whole - spent.sum(axis=1) - bounds
    shares = np.column_stack((spent[:, :2], bounds, spent[:, 2], rest))
    lines = []
    for name, mask in rows:
        middle = _US * np.median(shares[mask], axis=0)
        cells = [
            f"{us:.0f} us, {part:.0%}"
            for us, part in zip(middle, middle / middle.sum(), strict=True)
        ]
        lines.append((*name, *cells))
    return Table(
        ("stack", "state", *_SHARES), tuple(lines), "median of each part, in one pass more"
    )


def _bounds(tape: Tape, parts: Parts) -> Vector:
    """Return the time of the bounds of every tick [s], computed alone."""
    limits, dt = parts.team.limits, parts.dt
    times = np.empty(len(tape.states))
    for k, state in enumerate(tape.states):
        begun = perf_counter()
        viable_bounds(state.q_star, limits, dt, state.command, sent=state.command)
        times[k] = perf_counter() - begun
    return times


def _svd() -> float:
    """Return the median time of one singular value decomposition of a 20 x 20 matrix [us]."""
    matrix = np.random.default_rng(0).normal(size=(20, 20))
    times = []
    for _ in range(300):
        begun = perf_counter()
        np.linalg.svd(matrix)
        times.append(perf_counter() - begun)
    return _US * float(np.median(times))


def _n(tape: Tape) -> int:
    """Return the length of chi."""
    return int(tape.states[0].q.size)


EXPERIMENT = Experiment(
    "a whole tick of the controller, and where its time goes", "passes", PASSES, run
)
