"""Obstacles, T, Sec. III-B c: with the base task, with the distance task, and with nothing.

MuJoCo with the impedance loop. What counts is the distance between the shapes that can touch, not
between the spheres that the controller knows.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lexstack.types import Matrix, Vector
from lexstack_bag.figures.figures import Analysis
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.obstacle_cases import BASE, DISTANCE, NOTHING, Case, cases
from lexstack_experiments.experiments.obstacle_pictures import draw_clearance, render_passing
from lexstack_experiments.loop import Loop
from lexstack_experiments.results import AT_MOST_ONE, Cell, Figure, Goal, Peer, Results, Table, zero
from lexstack_experiments.runs import analysed, run_reporting, scenario_of
from lexstack_sim.obstacles import Clearance
from lexstack_sim.plant import Plant

NAME = "obstacle"
_MOST = 0.6  # m: clearances are not looked at above this


@dataclass(frozen=True, slots=True)
class Outcome:
    """One way through one case.

    Attributes:
        case: which.
        variant: which.
        loop: the run.
        measured: its figures.
        time: s, shape (T,).
        clearance: least distance of the shapes to what they must not touch, m, shape (T,).
        touching: ticks in which something touched.
    """

    case: Case
    variant: str
    loop: Loop
    measured: Analysis
    time: Vector
    clearance: Vector
    touching: int

    @property
    def ee_error(self) -> Matrix:
        """Distance of the tools from their references, shape (T, N), mm."""
        return self.measured.time_series.ee_error


def run(options: Options) -> Results:
    """Run every case in every way, measure, draw."""
    whole = scenario_of(options.config, NAME)
    outcomes = [
        _outcome(case, variant, whole, options)
        for case in cases()[: options.cases]
        for variant in case.variants
    ]
    draw_clearance([(o.case.name, o.variant, o.time, o.clearance) for o in outcomes], options.out)
    shown = next(o for o in outcomes if o.variant == DISTANCE)
    said = render_passing(shown.loop, options.out / "obstacle-passing.jpg")
    options.say(said or "drew 2 pictures")
    return options.results(
        NAME,
        (*_goals(outcomes), *_stated(outcomes)),
        Table.of(_row(outcome) for outcome in outcomes),
        {
            "plant": "MuJoCo, joint impedance loop at 1 kHz",
            "rate_hz": whole.scenario.rate,
            "margin_mm": 50.0,
            "stacks": {variant: o.stack for o in cases() for variant, o in o.variants.items()},
        },
        (
            "clearance: between the robots' contact geometry and the obstacles; negative: depth.",
            "EE peak counts where the tools are asked to stay; EE final: mean of the last 0.5 s.",
        ),
    )


def _outcome(case: Case, variant: str, whole: ResolvedScenario, options: Options) -> Outcome:
    """Run one way through one case."""
    resolved = case.scenario(whole, variant, options.seed)
    loop = run_reporting(Loop(resolved), f"{case.name}, {variant}", options.say)
    assert isinstance(loop.plant, Plant)
    team = loop.parts.team
    measure = Clearance(loop.plant.world, team)
    clearance = [
        (measure.between(s.q, _MOST) if case.meet else measure.at(s.q, s.stamp, _MOST)).min()
        for s in loop.record.states
    ]
    return Outcome(
        case,
        variant,
        loop,
        analysed(loop),
        np.array([state.stamp for state in loop.record.states]),
        np.array(clearance),
        loop.plant.counters.contact,
    )


def _goals(outcomes: list[Outcome]) -> list[Figure]:
    """Return what is to be reached: nobody is touched, the command keeps its limits."""
    figures = []
    for variant in (DISTANCE, BASE):
        mine = [o for o in outcomes if o.variant == variant]
        names = {o.case.name for o in mine}
        beside = [o for o in outcomes if o.variant == NOTHING and o.case.name in names]
        least, other = (
            min((1e3 * float(o.clearance.min()) for o in group), default=None)
            for group in (mine, beside)
        )
        touching, touched = (float(sum(o.touching for o in group)) for group in (mine, beside))
        figures += [
            Figure(
                f"Least clearance, {variant}",
                least,
                "mm",
                Goal(">=", 0.0),
                "",
                Peer(NOTHING, other),
            ),
            Figure(
                f"Ticks in which something touches, {variant}",
                touching if mine else None,
                "",
                Goal("==", 0),
                "",
                Peer(NOTHING, touched),
            ),
        ]
    avoiding = [o for o in outcomes if o.variant != NOTHING]
    peak = max(o.measured.metrics.peak_acceleration_ratio or 0.0 for o in avoiding)
    empty = sum(o.measured.metrics.empty_bounds for o in avoiding)
    figures += [
        Figure("Peak acceleration of the command / limit", peak, "", AT_MOST_ONE),
        zero("Ticks with an empty box of bounds", empty),
        zero("Cases that are harmless by themselves", _harmless(outcomes)),
    ]
    return figures


def _harmless(outcomes: list[Outcome]) -> int:
    """Return the cases in which nothing touches though nothing is done: they would show nothing."""
    return sum(o.touching == 0 for o in outcomes if o.variant == NOTHING)


def _stated(outcomes: list[Outcome]) -> Iterable[Figure]:
    """Yield the errors of the tools where they are asked to stay, and where they end."""
    for outcome in outcomes:
        if outcome.variant == NOTHING:
            continue
        where = f"{outcome.case.name}, {outcome.variant}"
        if outcome.case.holds:
            yield Figure(f"Peak EE error: {where}", float(outcome.ee_error.max()), "mm")
        if not outcome.case.meet:
            yield Figure(f"Final EE error: {where}", _final(outcome), "mm")


def _row(outcome: Outcome) -> dict[str, Cell]:
    """Return one line of the table."""
    broken = [command.slacks[0] for command in outcome.loop.record.commands]
    return {
        "case": outcome.case.name,
        "way": outcome.variant,
        "clearance mm": 1e3 * float(outcome.clearance.min()),
        "touching, ticks": outcome.touching,
        "EE peak mm": float(outcome.ee_error.max()) if outcome.case.holds else None,
        "EE final mm": _final(outcome),
        "acc. ratio": outcome.measured.metrics.peak_acceleration_ratio,
        "slack of distances mm/s": 1e3 * float(max(broken))
        if outcome.variant == DISTANCE
        else None,
    }


def _final(outcome: Outcome) -> float:
    """Return the larger error of the tools at the end [mm]."""
    return float(outcome.ee_error[outcome.time >= outcome.time[-1] - 0.5].mean(axis=0).max())


EXPERIMENT = Experiment(
    "obstacles that stand and move: base task, distance task, nothing", "cases", len(cases()), run
)
"""Registered under its name."""
