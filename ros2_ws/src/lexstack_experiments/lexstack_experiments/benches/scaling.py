"""What N robots cost: the whole tick of the controller, and the HQP alone, for 2 to 32 of them.

N mobile manipulators beside each other change their stack from `track` to `reach_base`, all at
once. Nothing couples them, so the cost is to grow with N and not with its cube. The clustered
solution is held against the dense one on the same problems.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import thread_time

import numpy as np

from lexstack.hqp import DaqpCascade, HqpProblem, make_solver
from lexstack.types import Vector
from lexstack_config.parts import Parts, build_controller
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.hierarchies.recorded import record
from lexstack_experiments.measuring import no_collection
from lexstack_experiments.replay import Tape
from lexstack_experiments.results import Figure, Goal, Results, Table
from lexstack_experiments.runs import changed, scenario_of

NAME = "scaling"
ROBOTS = (2, 4, 8, 16, 32)
PASSES = 7
_GOALS = {8: (4.5, 4.5), 32: (10.0, 20.0)}  # times the cost of two robots: whole tick, HQP
_SAME = 1e3  # 1e-9 m/s, rad/s
_US = 1e6
_DURATION, _SWITCH, _BLEND = 0.8, 0.2, 0.3  # s

_NOTES = (
    "Times, of the thread's clock: median over the ticks of a run of 0.8 s with a switch in it, of",
    "each tick the fastest pass: a tick of 32 robots is so long that caches are lost in it often.",
    "dense: chi of the clustered solver against one solve of all joints together.",
)


@dataclass(slots=True)
class _Case:
    """A team with what it is to be measured on."""

    resolved: ResolvedScenario
    tape: Tape
    problems: list[HqpProblem]
    difference: float

    @classmethod
    def of(cls, resolved: ResolvedScenario) -> _Case:
        """Record a scenario."""
        problems = [p for sequence in record(resolved, 10**6) for p in sequence.problems]
        return cls(resolved, Tape.of(resolved), problems, _difference(resolved, problems))


def team_of(resolved: ResolvedScenario, count: int) -> ResolvedScenario:
    """Return a short scenario for ``count`` robots of the first robot's kind, 2 m apart."""
    place = next(iter(resolved.scenario.robots.values()))
    names = [f"robot_{i + 1}" for i in range(count)]
    # The other stacks name robots that are not there.
    stacks = {name: resolved.stacks[name] for name in ("track", "reach_base")}
    return changed(
        replace(resolved, stacks=stacks),
        robots={name: replace(place, base=(2.0 * i, 0.0, 0.0)) for i, name in enumerate(names)},
        base_target={name: (2.0 * i, -0.5, 0.0) for i, name in enumerate(names)},
        events=(EventConfig(at=_SWITCH, switch="reach_base", duration=_BLEND),),
        duration=_DURATION,
    )


def run(options: Options) -> Results:
    """Measure all sizes in turns, so that what disturbs one disturbs all."""
    base = scenario_of(options.config)
    cases = {}
    for count in ROBOTS:
        cases[count] = _Case.of(team_of(base, count))
        options.say(f"{count} robots: recorded")
    ticks, solves = ({count: _best(case) for count, case in cases.items()} for _ in range(2))
    for number in range(options.cases + 1):
        for count, case in cases.items():
            tick, solve = _tick(case), _solve(case)
            if number:  # the first one warms up
                np.minimum(ticks[count], tick, out=ticks[count])
                np.minimum(solves[count], solve, out=solves[count])
        options.say(f"pass {number} of {options.cases}")
    lines, figures = [], []
    for count, case in cases.items():
        spent = [
            (float(np.median(t[count])), float(np.median(t[ROBOTS[0]]))) for t in (ticks, solves)
        ]
        ratios = [us / two for us, two in spent]
        cells = [cell for (us, _), ratio in zip(spent, ratios, strict=True) for cell in (us, ratio)]
        lines.append((count, *cells, f"{case.difference:.1e}"))
        if count in _GOALS:
            figures += [
                Figure(f"{what}, {count} robots over {ROBOTS[0]}", ratio, "x", Goal("<=", goal))
                for what, ratio, goal in zip(
                    ("whole tick", "HQP"), ratios, _GOALS[count], strict=True
                )
            ]
    apart = max(case.difference for case in cases.values())
    figures.append(
        Figure("chi against the dense solution", 1e9 * apart, "1e-9 m/s, rad/s", Goal("<=", _SAME))
    )
    columns = ("robots", "tick us", "tick, x 2 robots", "HQP us", "HQP, x 2 robots", "dense")
    return options.results(
        NAME,
        figures,
        Table(columns, lines),
        {"plant": "ideal", "rate_hz": base.scenario.rate, "joints_per_robot": 10},
        _NOTES,
    )


def _best(case: _Case) -> Vector:
    """Return a time for every tick that the first one measured will beat."""
    return np.full(len(case.problems), np.inf)


def _tick(case: _Case) -> Vector:
    """Return the time of every tick of the controller [us]."""
    controller = build_controller(case.resolved, Parts.of(case.resolved))
    return _US * case.tape.play(controller, clock=thread_time)[0]


def _solve(case: _Case) -> Vector:
    """Return the time of every problem of the case [us]."""
    solver = make_solver(case.resolved.scenario.solver)
    times, warm = [], None
    with no_collection():
        for problem in case.problems:
            begun = thread_time()
            warm = solver.solve(problem, warm)
            times.append(thread_time() - begun)
    return _US * np.array(times)


def _difference(resolved: ResolvedScenario, problems: list[HqpProblem]) -> float:
    """Return how far the clustered chi is from the dense one, on every fifth problem."""
    clustered, dense = make_solver(resolved.scenario.solver), DaqpCascade()
    return max(
        float(np.abs(clustered.solve(p).chi - dense.solve(p).chi).max()) for p in problems[::5]
    )


EXPERIMENT = Experiment("what N robots cost, whole tick and HQP", "passes", PASSES, run)
