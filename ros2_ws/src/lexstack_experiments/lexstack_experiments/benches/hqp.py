"""The HQP solver beside its peers, on the problems of the closed loop, in one run.

The problems are those that the controller solves in the paper's sequence in the ideal plant: 2
levels while it tracks, 3 with base targets or posture, level 1 and follow-chi in a transition. They
are recorded in this run, twice: with the robots' limits, and with limits of a tenth, at which
joints are at their bounds most of the time. Those of the scenario `obstacle` have inequality rows
on top: distances of spheres. Every solver gets the same problems in the same order, with its last
solution to start from if it can use it; the time is that of the thread's processor for the call,
stacking included.
"""

from __future__ import annotations

from contextlib import ExitStack

import numpy as np

import lexstack_experiments.solvers  # noqa: F401 - brings quadprog
from lexstack.hqp import DEFAULT_SOLVER, make_solver
from lexstack_experiments.benches.against import NOTHING, against_hqp
from lexstack_experiments.benches.goals import with_goals
from lexstack_experiments.benches.hqp_runs import (
    Contestant,
    Local,
    Placo,
    Run,
    has_intervals,
    measured,
)
from lexstack_experiments.benches.peers import MISSING, child_with
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.hierarchies.peers import STRICT, DaqpHierarchy, installed
from lexstack_experiments.hierarchies.recorded import Sequence, record
from lexstack_experiments.hierarchies.weighted import WEIGHTED
from lexstack_experiments.measuring import paired_ratio
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table, zero
from lexstack_experiments.runs import scenario_of

NAME = "hqp"
PASSES = 5
LONGEST = 200  # problems of a sequence
SLOWER = 10.0
OTHERS = ("daqp", "proxqp", "quadprog")
OURS = f"lexstack {DEFAULT_SOLVER}"
_PEER = DaqpHierarchy.name
_AT_BOUNDS = ", at bounds"
_NAMES = {
    "track": "2 levels",
    "reach_base": "base",
    "posture_mid_range": "posture",
    "avoid": "3 levels, distances above",
    "avoid_base": "4 levels, distances above",
}

_COLUMNS = ("sequence", "solver", "failures", "excess", "outside", "us p50", "us p99", "us quiet")
_NOTES = (
    "over ours: p50 of a solver over that of the default one, turn by turn, the median of the",
    "turns; in brackets the problems on which it failed. failures: no answer, or an excess above",
    "1e-6; excess: of a level's residual over the least possible one (certificate of weak",
    "duality), the largest of the sequence; outside: how far chi left the bounds. us p50, p99:",
    "over all passes; quiet: median over the problems of the fastest pass of each. Those with",
    "weights have no strict levels, so most of their answers count as failures; inequality rows",
    "are not put to them. Times are of the thread's processor. Ratios to DAQP's hierarchy have a",
    "goal only where it is strict.",
)


def run(options: Options) -> Results:
    """Record, let everybody solve, and compare."""
    sequences = recorded(options)
    options.say(f"recorded {sum(len(s.problems) for s in sequences.values())} problems")
    with ExitStack() as stack:
        contestants, missing = _contestants(options, stack)
        runs = {}
        for name, sequence in sequences.items():
            runs[name] = measured(sequence, contestants, options.cases)
            options.say(f"{name}: {sequence.pressed:.0%} at bounds")
    before = against_hqp(sequences, options) if options.against else NOTHING
    about = tuple(
        (name, len(s.problems), len(s.problems[0].levels), s.pressed)
        for name, s in sequences.items()
    )
    return options.results(
        NAME,
        with_goals(NAME, (*_figures(runs), *before[0])),
        (
            _ratios(runs, [one.name for one in contestants]),
            *before[1],
            Table(
                _COLUMNS,
                [
                    _line(name, solver, one)
                    for name, by in runs.items()
                    for solver, one in by.items()
                ],
                "times, failures, excess",
            ),
            _who(contestants),
            Table(("sequence", "problems", "levels", "share at bounds"), about, "the problems"),
        ),
        {"plant": "ideal", "rate_hz": 100.0, "robots": 2, "slower": SLOWER},
        (*_NOTES, *missing),
    )


def recorded(options: Options) -> dict[str, Sequence]:
    """Return the sequences by their names."""
    resolved = scenario_of(options.config)
    sequences = {
        f"{_name(sequence)}{suffix}": sequence
        for suffix, slower in (("", 1.0), (_AT_BOUNDS, SLOWER))
        for sequence in record(resolved, LONGEST, slower)
    }
    sequences |= {
        _name(sequence): sequence
        for sequence in record(scenario_of(options.config, "obstacle"), LONGEST)
        if has_intervals(sequence.problems) and not sequence.blending
    }
    return sequences


def _contestants(options: Options, stack: ExitStack) -> tuple[list[Contestant], list[str]]:
    """Return everybody who is here, ours first, and a line for each who is not."""
    ours = [
        Local(make_solver(name), f"lexstack {name}", "a strict hierarchy")
        for name in (DEFAULT_SOLVER, *OTHERS)
    ]
    peers, names = installed((*STRICT, *WEIGHTED))
    missing = [f"Not installed, so not in the tables: {name}." for name in names]
    found: list[Contestant] = [*ours, *(Local(peer) for peer in peers)]
    placo = child_with("placo", "hqp_placo", options.peers)
    if placo is None:
        missing.append(MISSING["placo"])
    else:
        found.append(Placo(stack.enter_context(placo)))
    return found, missing


def _name(sequence: Sequence) -> str:
    """Return what a sequence is called."""
    if sequence.blending:
        return f"follow-chi to {sequence.stack.removesuffix('_mid_range')}"
    return _NAMES.get(sequence.stack, sequence.stack)


def _ratios(runs: dict[str, dict[str, Run]], solvers: list[str]) -> Table:
    """Return how many times as long as ours everybody takes."""
    others = [name for name in solvers if name != OURS]
    lines = [
        (name, *(_ratio(by.get(other), by[OURS]) for other in others)) for name, by in runs.items()
    ]
    return Table(("sequence", *others), lines, "p50 over ours, turn by turn (failures)")


def _ratio(other: Run | None, ours: Run) -> Cell:
    """Return a cell of the table of ratios."""
    if other is None:
        return None
    ratio = paired_ratio(other.times, ours.times)
    failures = f" ({other.failures})" if other.failures else ""
    return f"{ratio:.1f}{failures}"


def _who(contestants: list[Contestant]) -> Table:
    """Return what everybody solves, and whether that is strict."""
    lines = [(one.name, one.solves, "yes" if one.strict else "no") for one in contestants]
    return Table(("solver", "solves", "strict by design"), lines, "who solves what")


def _line(name: str, solver: str, found: Run) -> tuple[Cell, ...]:
    """Return a row of the table."""
    quiet = float(np.median(found.times.min(axis=0)))
    excess, outside = f"{found.excess:.1e}", f"{found.outside:.1e}"
    return name, solver, found.failures, excess, outside, found.p50, found.p99, quiet


def _figures(runs: dict[str, dict[str, Run]]) -> list[Figure]:
    """Return what the default solver is to reach, beside DAQP's hierarchy where that is strict."""
    figures = [
        zero("Failures of the default solver", sum(by[OURS].failures for by in runs.values())),
        Figure(
            "Excess of the default solver",
            1e9 * max(by[OURS].excess for by in runs.values()),
            "1e-9 m/s, rad/s",
            Goal("<=", 10.0),
        ),
    ]
    for name, by in runs.items():
        ours, other = by[OURS], by.get(_PEER)
        if other is not None and other.strict:
            ratio = paired_ratio(ours.times, other.times)
            figures.append(Figure(f"{name}: p50 over {_PEER}", ratio))
        peer = None if other is None else Peer(_PEER, other.p50)
        figures += [
            Figure(f"{name}: p50", ours.p50, "us", peer=peer),
            Figure(f"{name}: p99", ours.p99, "us"),
        ]
    return figures


EXPERIMENT = Experiment(
    "the HQP solver beside its peers, on recorded problems",
    "passes",
    PASSES,
    run,
    peers=("placo",),
    against=True,
)
