"""The problems that the controller solves in a closed loop, in the order of the ticks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lexstack.hqp import HqpProblem, Solution, make_solver
from lexstack.transition import Source
from lexstack_config.parts import Parts, build_controller
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.probes import WatchedSolver


@dataclass(frozen=True, slots=True)
class Sequence:
    """Problems of consecutive ticks.

    Attributes:
        stack: that was in effect.
        blending: whether the controller followed a source; it then solves level 1 and follow-chi.
        problems: in the order of the ticks.
        pressed: the share of them whose optimum has a joint at its bound.
    """

    stack: str
    blending: bool
    problems: tuple[HqpProblem, ...]
    pressed: float


def record(resolved: ResolvedScenario, longest: int, slower: float = 1.0) -> tuple[Sequence, ...]:
    """Return the sequences of a scenario in the ideal plant, each once, in the order of its ticks.

    Args:
        resolved: the scenario.
        longest: ticks of a sequence that are kept, from its first one on.
        slower: velocity and acceleration limits are divided by this, so that bounds hold.
    """
    parts = Parts.of(resolved)
    limits = parts.team.limits
    rates = {name: getattr(limits, name) / slower for name in ("velocity", "acceleration")}
    parts.team.limits = replace(limits, **rates)
    log: list[tuple[HqpProblem, Solution]] = []
    solver = resolved.scenario.solver
    controller = build_controller(
        resolved, parts, lambda: WatchedSolver(make_solver(solver), lambda *pair: log.append(pair))
    )
    loop = Loop(resolved, IdealPlant(resolved, parts.team), controller)
    found: dict[tuple[str, bool], list[tuple[HqpProblem, Solution]]] = {}
    for _ in range(round(resolved.scenario.duration * resolved.scenario.rate)):
        log.clear()
        command = loop.step()
        # What the controller solves as its own stand-in for the solver comes before, or has another
        # box.
        own = [pair for pair in log if pair[0].bounds is command.bounds][-1]
        key = command.stack, command.transition.source is not Source.NONE
        found.setdefault(key, []).append(own)
    return tuple(
        Sequence(
            stack,
            blending,
            tuple(problem for problem, _ in pairs[:longest]),
            float(np.mean([bool(solution.active.any()) for _, solution in pairs[:longest]])),
        )
        for (stack, blending), pairs in found.items()
    )
