"""A whole tick of the controller, stack by stack, with and without damping near singularities.

One and two robots go through track, reach_base, posture and track again, and then to targets out
of reach, in the ideal plant. Every pass serves the recorded states twice, with damping and without,
so that whatever else the machine does is met by both. Times are of the wall's clock, with garbage
collection off. One pass warms up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lexstack.hqp import Damper
from lexstack_config.parts import Parts, build_controller
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig, PoseConfig
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.reach_runs import Undamped
from lexstack_experiments.replay import Tape
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table
from lexstack_experiments.runs import changed, scenario_of

NAME = "tick"
PASSES = 5
_GOAL = 150.0  # us that damping may add where it acts
_US = 1e6
_OUT = 11.0  # s: from then on the targets are out of reach
_END = 15.0  # s
_HIGH = 2.5  # m above the floor: no tool comes so high
_SWITCHES = ((1.0, "reach_base"), (5.0, "posture"), (9.0, "track"))  # s

_FAR = "out of reach"

_COLUMNS = (
    "robots",
    "tick",
    "ticks",
    "us p50",
    "us p99",
    "us p50, quiet",
    "us p99, quiet",
    "us p50, undamped",
    "us p99, undamped",
    "us p50, quiet, undamped",
    "us p99, quiet, undamped",
)
_NOTES = (
    "p50, p99: over all ticks of all passes; quiet: over the ticks of the fastest pass of each;",
    "undamped: the same states served without damping.",
)

Times = NDArray[np.float64]


def run(options: Options) -> Results:
    """Record the runs of one robot and of two, and serve them again and again."""
    rows: list[tuple[Cell, ...]] = []
    figures: list[Figure] = []
    for robots in (1, 2):
        tape = Tape.of(_scenario(scenario_of(options.config), robots))
        options.say(f"{robots} robots: recorded {len(tape.states)} ticks")
        with_damping, without = _passes(tape, options)
        kinds = _kinds(tape)
        for kind in dict.fromkeys(kinds):
            mask = np.array([one == kind for one in kinds])
            damped, plain = _cells(with_damping[:, mask]), _cells(without[:, mask])
            rows.append((robots, kind, int(mask.sum()), *damped, *plain))
            goal = Goal("<=", _GOAL) if kind == _FAR else None
            name = f"{robots} robots, {kind}: what damping adds, quiet p50"
            figures.append(Figure(name, damped[2] - plain[2], "us", goal))
    return Results(
        NAME,
        options.seed,
        options.cases,
        tuple(figures),
        (Table(_COLUMNS, tuple(rows)),),
        {"plant": "ideal", "rate_hz": scenario_of(options.config).scenario.rate},
        _NOTES,
    )


def _scenario(resolved: ResolvedScenario, robots: int) -> ResolvedScenario:
    """Return the run of the first robots of a scenario."""
    scenario = resolved.scenario
    names = list(scenario.robots)[:robots]
    out = {
        name: PoseConfig((scenario.robots[name].base[0], 0.0, _HIGH), (1.0, 0.0, 0.0, 0.0))
        for name in names
    }
    events = [EventConfig(at=at, switch=stack) for at, stack in _SWITCHES]
    return changed(
        resolved,
        robots={name: scenario.robots[name] for name in names},
        base_target={name: scenario.base_target[name] for name in names},
        ee_target={},
        events=(*events, EventConfig(at=_OUT, ee_target=out)),
        duration=_END,
    )


def _passes(tape: Tape, options: Options) -> tuple[Times, Times]:
    """Return the times of every tick [us], with damping and without, (passes, ticks) each."""
    times: tuple[list[Times], list[Times]] = ([], [])
    for number in range(options.cases + 1):
        for law, kept in zip((Damper, Undamped), times, strict=True):
            parts = Parts.of(tape.resolved)
            damper = law(parts.team, parts.dt)
            spent, _ = tape.play(build_controller(tape.resolved, parts, damper=damper))
            if number:
                kept.append(_US * spent)
    return np.array(times[0]), np.array(times[1])


def _kinds(tape: Tape) -> list[str]:
    """Return what each tick is: a blend, a stack, or a target out of reach."""
    kinds = []
    for command, blending in zip(tape.commands, tape.blending, strict=True):
        idle = _FAR if command.stamp >= _OUT else command.stack
        kinds.append("blend" if blending else idle)
    return kinds


def _cells(times: Times) -> tuple[float, float, float, float]:
    """Return p50 and p99 of times, shape (passes, ticks), then of the fastest pass of each tick."""
    both = (times, times.min(axis=0))
    p50, p99 = ([float(np.percentile(some, part)) for some in both] for part in (50, 99))
    return p50[0], p99[0], p50[1], p99[1]


EXPERIMENT = Experiment(
    "a whole tick of the controller, with and without damping", "passes", PASSES, run
)
