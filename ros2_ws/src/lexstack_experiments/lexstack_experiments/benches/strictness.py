"""Whether priorities are strict: random hierarchies, every solver, certified excess of each level.

The excess of a level is what its residual exceeds the least one by that is possible without a
change of the levels above. It is certified (`hierarchies/certificate.py`): no solver is trusted,
and none is compared with another.
"""

from __future__ import annotations

import numpy as np

from lexstack.hqp import DEFAULT_SOLVER, DaqpCascade, HqpSolver, ProxqpCascade, make_solver
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.hierarchies.peers import STRICT, DaqpHierarchy, installed
from lexstack_experiments.hierarchies.random_problems import SINGULAR, problems, with_unit_rows
from lexstack_experiments.hierarchies.score import STRICT_WITHIN, Score, score
from lexstack_experiments.measuring import p50_p99
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table, zero
from lexstack_experiments.solvers import QuadprogCascade

NAME = "strictness"
PROBLEMS = 2400
GOAL, SINGULAR_GOAL = 10.0, 1e4  # in _UNIT, of a level
_UNIT = "1e-9 m/s, rad/s"
_US = 1e6

_UNIT_ROWS = f"{DaqpHierarchy.name}, rows of length 1"

_NOTES = (
    "Excess of a level: its residual minus the least possible one, by a certificate of weak",
    "duality; the largest of all levels and problems that were solved. Half of the problems have",
    "inequality rows; 10 to 80 variables, 1 to 5 levels. Near-singular: the least singular value",
    "of level 1 is 1e-2 to 1e-16. Outside: how far chi left the bounds. Failures: no answer, or",
    "an excess above 1e-6, near-singular 1e-5. DAQP's hierarchical mode divides each row by its",
    "length, so where a level is not met it minimises another norm than the one that is asked for:",
    "the last solver gets the same problems with rows of length 1.",
)


def run(options: Options) -> Results:
    """Score our solvers and the peers on the same problems."""
    ours: list[HqpSolver] = [
        make_solver(),
        DaqpCascade(),
        DaqpCascade(guesses=False),
        ProxqpCascade(guesses=False),
        QuadprogCascade(guesses=False),
    ]
    words = [
        f"{DEFAULT_SOLVER} (default)",
        "daqp",
        "daqp, every level",
        "proxqp, every level",
        "quadprog, every level",
    ]
    peers, missing = installed(STRICT)
    lines, figures = [], []
    named = list(zip([*ours, *peers], [*words, *(p.name for p in peers)], strict=True))
    named.append((DaqpHierarchy(), _UNIT_ROWS))
    for solver, name in named:
        given = problems(options.seed, options.cases)
        if name == _UNIT_ROWS:
            given = ((kind, with_unit_rows(each)) for kind, each in given)
        scores = score(solver, given, STRICT_WITHIN)
        lines += [_line(name, kind, part) for kind, part in scores.items()]
        options.say(f"{name}: {sum(part.failures for part in scores.values())} failures")
        if solver is ours[0]:
            figures = _figures(scores)
    notes = (*_NOTES, *(f"Not installed, so not in the table: {name}." for name in missing))
    columns = ("solver", "problems", "number", "failures", "excess", "outside", "us p50", "us p99")
    return options.results(
        NAME,
        figures,
        Table(columns, lines),
        {"variables": "10 to 80", "levels": "1 to 5"},
        notes,
    )


def _line(name: str, kind: str, part: Score) -> tuple[Cell, ...]:
    """Return a row of the table."""
    times = _US * np.array(part.times or [np.nan])
    excess, outside = f"{part.excess:.1e}", f"{max(part.outside, 0.0):.1e}"
    return name, kind, len(part.times), part.failures, excess, outside, *p50_p99(times)


def _figures(scores: dict[str, Score]) -> list[Figure]:
    """Return what the default solver is to reach."""
    failures = sum(part.failures for part in scores.values())
    worst = max(part.excess for kind, part in scores.items() if kind != SINGULAR)
    outside = max(part.outside for part in scores.values())
    singular = scores.get(SINGULAR)  # not among the first nine problems
    return [
        zero("Failures of the default solver", failures),
        Figure("Excess of the default solver", 1e9 * worst, _UNIT, Goal("<=", GOAL)),
        Figure(
            "Its excess next to singularities",
            1e9 * singular.excess if singular else None,
            _UNIT,
            Goal("<=", SINGULAR_GOAL),
        ),
        Figure("How far it left the bounds", max(1e9 * outside, 0.0), _UNIT, Goal("==", 0.0)),
    ]


EXPERIMENT = Experiment(
    "strict priorities on random problems, all solvers", "problems", PROBLEMS, run
)
