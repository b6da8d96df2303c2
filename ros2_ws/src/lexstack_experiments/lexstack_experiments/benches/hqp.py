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

from dataclasses import dataclass
from time import thread_time

import numpy as np
from numpy.typing import NDArray

import lexstack_experiments.solvers  # noqa: F401 - brings quadprog
from lexstack.hqp import HqpSolver, make_solver
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.hierarchies.peers import STRICT, WEIGHTED, Pink, installed
from lexstack_experiments.hierarchies.recorded import Sequence, record
from lexstack_experiments.hierarchies.score import STRICT_WITHIN, Score
from lexstack_experiments.measuring import no_collection, p50_p99
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table, zero
from lexstack_experiments.runs import scenario_of

NAME = "hqp"
PASSES = 5
LONGEST = 200  # problems of a sequence
SLOWER = 10.0
OURS = ("kernel", "daqp", "proxqp", "quadprog")
_US = 1e6
_AT_BOUNDS = ", at bounds"
# What a sequence's name has in it, and its goals of p50 and p99, us; the first that fits holds.
_GOALS = {
    _AT_BOUNDS: (30.0, 70.0),
    "distances": (35.0, 90.0),
    "follow-chi": (20.0, 45.0),
    "base": (25.0, 45.0),
    "posture": (28.0, 45.0),
}
_PEER, _RATIO = "DAQP hierarchical", 0.5
_NAMES = {
    "track": "2 levels",
    "reach_base": "base",
    "posture_mid_range": "posture",
    "avoid": "3 levels, distances above",
    "avoid_base": "4 levels, distances above",
}

_COLUMNS = ("sequence", "solver", "failures", "excess", "outside", "us p50", "us p99", "us quiet")
_NOTES = (
    "failures: no answer, or an excess above 1e-6; excess: of a level's residual over the least",
    "possible one (certificate of weak duality), the largest of the sequence; outside: how far chi",
    "left the bounds. us p50, p99: over all passes; quiet: median over the problems of the fastest",
    "pass of each. Pink has no strict levels: its costs fall by ten from level to level, and it",
    "takes no inequality rows. Times are of the thread's processor; ratios within a run hold on",
    "noisy machines, absolute times drift with them. Ratios to DAQP's hierarchy only where that is",
    "strict.",
)


@dataclass(frozen=True, slots=True)
class Run:
    """What a solver did on a sequence.

    Attributes:
        failures: no answer, or one that is not strict.
        excess: largest certified one.
        outside: how far chi left the bounds.
        times: shape (passes, problems) [us].
    """

    failures: int
    excess: float
    outside: float
    times: NDArray[np.float64]

    @property
    def p50(self) -> float:
        """Median over all passes [us]."""
        return float(np.median(self.times))

    @property
    def strict(self) -> bool:
        """Whether all problems were solved as a hierarchy demands."""
        return self.failures == 0 and self.excess <= STRICT_WITHIN


def run(options: Options) -> Results:
    """Record, let everybody solve, and compare."""
    resolved = scenario_of(options.config)
    sequences = {
        f"{_name(sequence)}{suffix}": sequence
        for suffix, slower in (("", 1.0), (_AT_BOUNDS, SLOWER))
        for sequence in record(resolved, LONGEST, slower)
    }
    sequences |= {
        _name(sequence): sequence
        for sequence in record(scenario_of(options.config, "obstacle"), LONGEST)
        if _has_intervals(sequence) and not sequence.blending
    }
    options.say(f"recorded {sum(len(s.problems) for s in sequences.values())} problems")
    peers, missing = installed((*STRICT, *WEIGHTED))
    solvers = {f"lexstack {name}": make_solver(name) for name in OURS}
    solvers |= {peer.name: peer for peer in peers}
    runs = {name: _measured(sequence, solvers, options) for name, sequence in sequences.items()}
    lines = [
        _line(name, solver, found) for name, by in runs.items() for solver, found in by.items()
    ]
    about = tuple(
        (name, len(s.problems), len(s.problems[0].levels), s.pressed)
        for name, s in sequences.items()
    )
    return options.results(
        NAME,
        _figures(runs),
        (
            Table(_COLUMNS, lines),
            Table(("sequence", "problems", "levels", "share at bounds"), about, "the problems"),
        ),
        {"plant": "ideal", "rate_hz": resolved.scenario.rate, "robots": 2, "slower": SLOWER},
        (*_NOTES, *(f"Not installed, so not in the table: {name}." for name in missing)),
    )


def _name(sequence: Sequence) -> str:
    """Return what a sequence is called."""
    if sequence.blending:
        return f"follow-chi to {sequence.stack.removesuffix('_mid_range')}"
    return _NAMES.get(sequence.stack, sequence.stack)


def _has_intervals(sequence: Sequence) -> bool:
    """Return whether a sequence has inequality rows."""
    tasks = [task for level in sequence.problems[0].levels for task in level]
    return any((task.lower != task.upper).any() for task in tasks)


def _measured(
    sequence: Sequence, solvers: dict[str, HqpSolver], options: Options
) -> dict[str, Run]:
    """Return what every solver does on a sequence; the passes of the solvers take turns."""
    if _has_intervals(sequence):
        solvers = {name: s for name, s in solvers.items() if not isinstance(s, Pink)}
    times = {name: np.empty((options.cases, len(sequence.problems))) for name in solvers}
    judged = {name: _judge(sequence, solver) for name, solver in solvers.items()}
    with no_collection():
        for number in range(options.cases):
            for name, solver in solvers.items():
                times[name][number] = _US * _timed(sequence, solver)
    options.say(f"{_name(sequence)}: {sequence.pressed:.0%} at bounds")
    return {name: Run(*judged[name], times[name]) for name in solvers}


def _timed(sequence: Sequence, solver: HqpSolver) -> NDArray[np.float64]:
    """Return the processor's time of each problem [s], warm from the one before."""
    times, warm = np.empty(len(sequence.problems)), None
    for k, problem in enumerate(sequence.problems):
        begun = thread_time()
        warm = solver.solve(problem, warm)
        times[k] = thread_time() - begun
    return times


def _judge(sequence: Sequence, solver: HqpSolver) -> tuple[int, float, float]:
    """Return failures, largest excess and largest way out of the bounds; it warms up, too."""
    found, warm = Score(STRICT_WITHIN), None
    for problem in sequence.problems:
        warm = found.add(problem, solver, warm=warm)
    return found.failures, found.excess, found.outside


def _line(name: str, solver: str, found: Run) -> tuple[Cell, ...]:
    """Return a row of the table."""
    quiet = float(np.median(found.times.min(axis=0)))
    excess, outside = f"{found.excess:.1e}", f"{found.outside:.1e}"
    return name, solver, found.failures, excess, outside, *p50_p99(found.times), quiet


def _figures(runs: dict[str, dict[str, Run]]) -> list[Figure]:
    """Return what the default solver is to reach, beside the fastest strict peer."""
    default = f"lexstack {OURS[0]}"
    figures = [
        zero("Failures of the default solver", sum(by[default].failures for by in runs.values())),
        Figure(
            "Excess of the default solver",
            1e9 * max(by[default].excess for by in runs.values()),
            "1e-9 m/s, rad/s",
            Goal("<=", 10.0),
        ),
    ]
    for name, by in runs.items():
        figures += _of_sequence(name, by)
    return figures


def _of_sequence(name: str, by: dict[str, Run]) -> list[Figure]:
    """Return the figures of one sequence: the ratio to the compiled peer first, then times."""
    ours, other = by[f"lexstack {OURS[0]}"], by.get(_PEER)
    figures = []
    if other is not None and other.strict:
        peer = Peer(f"{_PEER}, us", other.p50)
        goal = Goal("<=", _RATIO)
        figures.append(Figure(f"{name}: p50 over its", ours.p50 / other.p50, "", goal, "", peer))
    goals = next((both for key, both in _GOALS.items() if key in name), None)
    values = (ours.p50, float(np.percentile(ours.times, 99.0)))
    for place, (what, value) in enumerate(zip(("p50", "p99"), values, strict=True)):
        goal = None if goals is None else Goal("<=", goals[place])
        figures.append(Figure(f"{name}: {what}", value, "us", goal))
    return figures


EXPERIMENT = Experiment(
    "the HQP solver beside its peers, on recorded problems", "passes", PASSES, run
)
