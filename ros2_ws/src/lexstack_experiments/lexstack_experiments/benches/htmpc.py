"""A full two-level solve of the HTMPC in closed loop, beside the paper's way to do it.

Every row is a closed loop of its own on the ideal plant: the tool is held, the base gets the square
wave of paper H with random peaks that the arm cannot reach, and with spheres five obstacles go
around. The rows take turns, so that what else the machine does falls on all of them alike.
``authors`` is the problem of the paper; ``lexstack`` has hard limits, bent steps and resuming
besides.

The paper's way (CasADi's sparse QP, its object built anew for every QP) solves the problem of
``authors`` from the states, guesses and references of that loop.
"""

from __future__ import annotations

import dataclasses
from importlib.util import find_spec

import casadi as ca
import numpy as np

from lexstack.errors import ModelError
from lexstack_experiments.baselines.htmpc_paper import SOLVERS
from lexstack_experiments.benches.against import NOTHING, Found, against_htmpc
from lexstack_experiments.benches.goals import with_goals
from lexstack_experiments.benches.htmpc_loops import OBSTACLES, Loop, Row, ms, tracks_of
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.measuring import no_collection
from lexstack_experiments.results import Figure, Peer, Results, Table, zero

__all__ = ["EXPERIMENT", "HORIZONS", "ROBOTS", "paper_solver", "run", "tracks_of"]

NAME = "htmpc"
SOLVES = 1000
ROBOTS = ("ur10_ridgeback", "panda_summit")
HORIZONS = (10, 20, 30)
PARAMETERS = ("authors", "lexstack")
_TURN = 50  # solves of one row before it is the next one's turn
_STATES, _TURNS = 300, 3  # that another clone gets, per row, and how often

_NOTES = (
    "cpu ms: time of the thread for a two-level solve, without what others took; ms: wall time.",
    "failed: solves of which a level failed; paper over ours: cpu p50 of the paper's way over ours",
    "in this run.",
)


def run(options: Options) -> Results:
    """Run all rows in turns, and compare."""
    paper = paper_solver()
    options.say(f"the paper's way with CasADi's {paper}")
    rows = [
        Row(robot, horizon, spheres, parameters)
        for robot in ROBOTS
        for horizon in HORIZONS
        for spheres in (False, True)
        for parameters in PARAMETERS
    ]
    loops = {}
    for row in rows:
        keep = min(_STATES, options.cases) if _is_compared(row, options) else 0
        loops[row] = Loop(row, options, paper, keep)
        loops[row].advance(1)  # the first solve warms up and does not count
        loops[row].wall.clear()
        loops[row].cpu.clear()
    options.say("all built")
    with no_collection():
        for begun in range(0, options.cases, _TURN):
            for loop in loops.values():
                loop.advance(min(_TURN, options.cases - begun))
            options.say(f"{min(begun + _TURN, options.cases)} of {options.cases} solves per row")
    before = _against(loops, options) if options.against else NOTHING
    failures = sum(loop.paper_failed for loop in loops.values())
    return options.results(
        NAME,
        with_goals(NAME, (*_figures(loops, paper), *before[0])),
        (*before[1], Table.of((loop.cells() for loop in loops.values()), "two levels")),
        {"paper_qp_solver": paper, "paper_qp_failures": failures, "obstacles": OBSTACLES},
        _NOTES,
    )


def paper_solver() -> str:
    """Return the first QP solver of the paper's way that works here: Gurobi if it is there."""
    for name in SOLVERS:
        if find_spec("gurobipy") if name == "gurobi" else ca.has_conic(name):
            return name
    raise ModelError(f"CasADi has none of the QP solvers {', '.join(SOLVERS)}")


def _is_compared(row: Row, options: Options) -> bool:
    """Return whether another clone gets the states of a row."""
    return options.against is not None and row.parameters == "lexstack"


def _against(loops: dict[Row, Loop], options: Options) -> Found:
    """Compare with another clone on the same states."""
    rows = {
        row.text: (loop.described, loop.states)
        for row, loop in loops.items()
        if _is_compared(row, options)
    }
    return against_htmpc(rows, options, _TURNS)


def _figures(loops: dict[Row, Loop], paper: str) -> list[Figure]:
    """Return the figures to reach: ratios within this run, then thread times."""
    figures = []
    for row, loop in loops.items():
        if loop.paper:
            figures.append(Figure(f"{row.text}: the paper's way over ours", loop.ratio))
        if row.horizon == 20 and not row.spheres:
            short = loops[dataclasses.replace(row, horizon=10)]
            ratio = float(np.median(loop.cpu) / np.median(short.cpu))
            figures.append(Figure(f"{row.text}: cpu over N = 10", ratio))
        peer = Peer(f"the paper's way, {paper}", ms(loop.paper_cpu)) if loop.paper else None
        told = "63 ms mean" if row.horizon == 10 else ""
        figures += [
            Figure(f"{row.text}: p50", ms(loop.cpu), "ms", None, told, peer),
            Figure(f"{row.text}: p99", ms(loop.cpu, 99), "ms"),
        ]
    failed = sum(loop.failed for loop in loops.values())
    return [*figures, zero("Solves with a failed level", float(failed))]


EXPERIMENT = Experiment(
    "the HTMPC beside the paper's way",
    "solves per row",
    SOLVES,
    run,
    against=True,
)
