"""Targets out of reach: when the robots come to rest, and how near; targets within reach: when.

No damping, plain damping (Levenberg and Marquardt's, of every tool level) and the product's own,
on random targets that no constant was tuned on. One process, an exact integrator: what moves is
what the law asks for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.config.resolved import ResolvedScenario
from lexstack.robots import Team
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.reach_cases import KINDS, Case, out_of_reach, within_reach
from lexstack_experiments.experiments.reach_runs import LAWS, Motion, run
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table
from lexstack_experiments.runs import changed, scenario_of

NAME = "reach"
SECONDS = 10.0
_TAIL = 3.0  # s, the end of a run over which changes of sign are counted
_SEVERAL = ("relative",)  # open: reported, and not among the goals
_COLUMNS = ("law", "targets", "kind", "cases", "at rest", "median s", "longest s",
            "sign changes 1/s", "largest gap m2")  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """What one run came to: times [s], None where they did not come."""

    kind: str
    law: str
    rest: float | None
    signs: float
    gap: float
    reached: float | None


def run_experiment(options: Options) -> Results:
    """Run all cases with all laws, and compare."""
    resolved = scenario_of(options.config, "transition-sequence")
    resolved = changed(resolved, seed=options.seed)
    team = Team.from_scenario(resolved)
    home = team.home(resolved)
    outside: list[Outcome] = []
    inside: list[Outcome] = []
    for place, kind in enumerate(KINDS):
        for number in range(options.cases):
            rng = np.random.default_rng([options.seed, place, number])
            beyond = out_of_reach(kind, rng, team, home)
            within = within_reach(kind, rng, team, home)
            outside += [_outcome(resolved, beyond, law, within=False) for law in LAWS]
            inside += [_outcome(resolved, within, law, within=True) for law in LAWS]
        options.say(f"{kind}: {options.cases} targets out of reach, as many within")
    rows = [*_rows(outside, "out of reach"), *_rows(inside, "within reach")]
    return options.results(
        NAME,
        (*_rest_figures(outside), *_reach_figures(inside)),
        Table(_COLUMNS, rows),
        {"plant": "exact integrator", "seconds": SECONDS, "kinds": len(KINDS)},
    )


def _outcome(resolved: ResolvedScenario, case: Case, law: str, *, within: bool) -> Outcome:
    """Return what became of a target within reach, or of one out of it."""
    motion: Motion = run(resolved, case, law, SECONDS)
    rest, signs = motion.rest_after(), motion.sign_changes(_TAIL)
    gap = 0.0 if within else motion.excess()
    return Outcome(case.kind, law, rest, signs, gap, motion.reached_after() if within else None)


def _rest_figures(outcomes: list[Outcome]) -> list[Figure]:
    """Return the figures of targets out of reach, of one pose level alone."""
    judged = [each for each in outcomes if each.kind not in _SEVERAL]
    ours = [each for each in judged if each.law == "lexstack"]
    share, median = _share(ours), _median([each.rest for each in ours])
    plain = _share([each for each in judged if each.law == "plain damping"])
    at_rest = [each for each in ours if each.rest is not None]
    return [
        Figure("Targets out of reach: at rest within 10 s", share, "%", Goal(">=", 98.0), "",
               Peer("plain damping", plain)),
        Figure("Time to rest, median", median, "s", Goal("<=", 5.5)),
        Figure("Sign changes of a joint's velocity at the end, at rest",
               max((each.signs for each in at_rest), default=None), "1/s", Goal("==", 0.0)),
        Figure("Half the squared error above the least, at rest, 99 % of cases",
               _quantile([each.gap for each in at_rest], 0.99), "m2", Goal("<=", 1e-6)),
    ]  # fmt: skip


def _reach_figures(outcomes: list[Outcome]) -> list[Figure]:
    """Return the figures of targets within reach."""
    ratios = {law: _ratios(outcomes, law) for law in LAWS}
    ours, plain = ratios["lexstack"], ratios["plain damping"]
    lost = sum(
        mine.reached is None and before.reached is not None
        for mine, before in zip(_of(outcomes, "lexstack"), _of(outcomes, "undamped"), strict=True)
    )
    return [
        Figure("Targets within reach that undamped are reached, and are not", lost, "",
               Goal("==", 0)),
        Figure("Time to reach, against undamped, median", _quantile(ours, 0.5), "x",
               Goal("<=", 1.02), "", Peer("plain damping", _quantile(plain, 0.5))),
        Figure("Time to reach, against undamped, longest", _quantile(ours, 1.0), "x",
               Goal("<=", 1.10), "", Peer("plain damping", _quantile(plain, 1.0))),
    ]  # fmt: skip


def _of(outcomes: list[Outcome], law: str) -> list[Outcome]:
    """Return the outcomes of one law."""
    return [each for each in outcomes if each.law == law]


def _ratios(outcomes: list[Outcome], law: str) -> list[float]:
    """Return the times to reach against undamped, of the cases that both reach."""
    pairs = zip(_of(outcomes, law), _of(outcomes, "undamped"), strict=True)
    return [mine.reached / other.reached for mine, other in pairs if mine.reached and other.reached]


def _share(outcomes: list[Outcome]) -> float | None:
    """Return which share is at rest at the end, %."""
    if not outcomes:
        return None
    return 100.0 * sum(each.rest is not None for each in outcomes) / len(outcomes)


def _median(times: list[float | None]) -> float | None:
    """Return the median, with what did not come as late as can be."""
    return _quantile([np.inf if time is None else time for time in times], 0.5)


def _quantile(values: list[float], share: float) -> float | None:
    """Return a quantile, None of nothing."""
    return float(np.quantile(values, share, method="higher")) if values else None


def _rows(outcomes: list[Outcome], targets: str) -> list[tuple[Cell, ...]]:
    """Return one row for each law and kind."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        for kind in KINDS:
            mine = [each for each in outcomes if each.law == law and each.kind == kind]
            times = [each.rest for each in mine if each.rest is not None]
            median, longest = _quantile(times, 0.5), _quantile(times, 1.0)
            signs = max((each.signs for each in mine), default=0.0)
            gap = max((each.gap for each in mine), default=0.0)
            counted = (law, targets, kind, len(mine), len(times))
            rows.append((*counted, median, longest, signs, gap))
    return rows


EXPERIMENT = Experiment(
    "targets out of reach and within, with three ways to treat singularities",
    "targets of each kind, out of reach and within",
    25,
    run_experiment,
)
