"""A whole tick of the controller, stack by stack, with and without damping near singularities.

One and two robots go through track, reach_base, posture and track again, and then to targets out
of reach, in the ideal plant. Every pass serves the recorded states with damping, without it, and
with the cascade in place of the compiled kernel besides, so that whatever else the machine does is
met by all. Times are of the thread's processor, with garbage collection off. One pass warms up.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import thread_time

import numpy as np
from numpy.typing import NDArray

from lexstack.hqp import Damper, make_solver
from lexstack_config.parts import Parts, build_controller
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig, PoseConfig
from lexstack_experiments.benches.against import NOTHING, against_tick
from lexstack_experiments.benches.child import in_turns
from lexstack_experiments.benches.goals import with_goals
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.reach_runs import Undamped
from lexstack_experiments.measuring import p50_p99, paired_ratio
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

_FAR, _BLEND = "out of reach", "blend"
_OURS, _CASCADE, _UNDAMPED = "default", "cascade", "undamped"

_RATIOS = (
    "robots",
    "tick",
    "p50 over the cascade",
    "p99 over the cascade",
    "undamped over it, p50",
)
_COLUMNS = (
    "robots",
    "tick",
    "ticks",
    "us p50",
    "us p99",
    "us p50, quiet",
    "us p50, cascade",
    "us p99, cascade",
    "us p50, undamped",
    "us p99, undamped",
)
_NOTES = (
    "p50, p99: over all ticks of all passes; quiet: over the ticks of the fastest pass of each;",
    "cascade: the same states served with the solver daqp; undamped: without damping. Ratios are",
    "taken pass by pass, the median of the passes. Outside a blend: the stack that takes longest.",
)

Times = NDArray[np.float64]


def run(options: Options) -> Results:
    """Record the runs of one robot and of two, and serve them again and again."""
    ratios: list[tuple[Cell, ...]] = []
    rows: list[tuple[Cell, ...]] = []
    figures: list[Figure] = []
    for robots in (1, 2):
        tape = Tape.of(_scenario(scenario_of(options.config), robots))
        options.say(f"{robots} robots: recorded {len(tape.states)} ticks")
        passes, kinds = _passes(tape, options), _kinds(tape)
        masks = {kind: np.array([one == kind for one in kinds]) for kind in dict.fromkeys(kinds)}
        for kind, mask in masks.items():
            times = {name: every[:, mask] for name, every in passes.items()}
            ratios.append((robots, kind, *_ratios(times)))
            rows.append((robots, kind, int(mask.sum()), *_cells(times)))
            figures.append(_over(f"{robots} robots, {kind}", times))
        figures += _of_goals(robots, {k: passes[_OURS][:, m] for k, m in masks.items()})
        far = {name: every[:, masks[_FAR]].min(axis=0) for name, every in passes.items()}
        added = float(np.median(far[_OURS]) - np.median(far[_UNDAMPED]))
        name = f"{robots} robots, {_FAR}: what damping adds, quiet p50"
        figures.append(Figure(name, added, "us", Goal("<=", _GOAL)))
    before = against_tick(options) if options.against else NOTHING
    return options.results(
        NAME,
        with_goals(NAME, (*figures, *before[0])),
        (Table(_RATIOS, ratios, "ratios"), *before[1], Table(_COLUMNS, rows, "times")),
        {"plant": "ideal", "rate_hz": scenario_of(options.config).scenario.rate},
        _NOTES,
    )


def _over(name: str, times: dict[str, Times]) -> Figure:
    """Return a tick's p50 over that with the cascade, pass by pass."""
    return Figure(f"{name}: p50 over the cascade", paired_ratio(times[_OURS], times[_CASCADE]))


def _of_goals(robots: int, times: dict[str, Times]) -> list[Figure]:
    """Return the medians that have a goal; outside a blend that of the slowest stack in reach."""
    idle = [float(np.median(t)) for kind, t in times.items() if kind not in {_FAR, _BLEND}]
    blend = float(np.median(times[_BLEND]))
    return [
        Figure(f"{robots} robots, outside a blend: p50", max(idle), "us"),
        Figure(f"{robots} robots, in a blend: p50", blend, "us"),
    ]


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


def _passes(tape: Tape, options: Options) -> dict[str, Times]:
    """Return the times of every tick [us] of each variant, (passes, ticks); one pass warms up."""
    variants: dict[str, Callable[[], Times]] = {
        _OURS: partial(_pass, tape, Damper),
        _CASCADE: partial(_pass, tape, Damper, "daqp"),
        _UNDAMPED: partial(_pass, tape, Undamped),
    }
    times = in_turns(options.cases + 1, variants)
    return {name: every[1:] for name, every in times.items()}


def _pass(tape: Tape, law: type[Damper], solver: str = "") -> Times:
    """Return the thread's processor time of every tick of a new controller [us]."""
    parts = Parts.of(tape.resolved)
    factory = partial(make_solver, solver) if solver else None
    damper = law(parts.team, parts.dt)
    controller = build_controller(tape.resolved, parts, factory, damper=damper)
    return _US * tape.play(controller, clock=thread_time)[0]


def _kinds(tape: Tape) -> list[str]:
    """Return what each tick is: a blend, a stack, or a target out of reach."""
    kinds = []
    for command, blending in zip(tape.commands, tape.blending, strict=True):
        idle = _FAR if command.stamp >= _OUT else command.stack
        kinds.append(_BLEND if blending else idle)
    return kinds


def _ratios(times: dict[str, Times]) -> tuple[float, float, float]:
    """Return p50 and p99 over the cascade, and the p50 without damping over that with it."""
    p50, p99 = (paired_ratio(times[_OURS], times[_CASCADE], part) for part in (50.0, 99.0))
    return p50, p99, paired_ratio(times[_UNDAMPED], times[_OURS])


def _cells(times: dict[str, Times]) -> tuple[float, ...]:
    """Return p50 and p99, and p50 of the fastest passes; then p50 and p99 of the other variants."""
    quiet = float(np.median(times[_OURS].min(axis=0)))
    return *p50_p99(times[_OURS]), quiet, *p50_p99(times[_CASCADE]), *p50_p99(times[_UNDAMPED])


EXPERIMENT = Experiment(
    "a whole tick of the controller beside the cascade's, with and without damping",
    "passes",
    PASSES,
    run,
    against=True,
)
