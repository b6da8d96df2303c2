"""Further targets out of reach: a hair beyond, jerk limits, two levels, and the way back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiment import Options
from lexstack_experiments.experiments.reach_cases import Case, out_of_reach, straight_up
from lexstack_experiments.experiments.reach_runs import Motion, errors, gap, run
from lexstack_experiments.results import Cell, Figure, Goal, Table

_HAIR = 1e-4  # m
_AWAY, _BACK = 8.0, 6.0  # s, towards a target out of reach, and back home
_HOME = 1e-3  # m or rad
_LEAST = 1e-6  # m^2: nearer than this to the least half squared error is at a local minimum
_KINDS = ("free", "free position", "held", "held position", "two robots", "posture")
_COLUMNS = ("what", "kind", "beyond m", "at rest s", "sign changes 1/s", "gap m2",
            "acceleration / limit", "told")  # fmt: skip


def more_figures(
    resolved: ResolvedScenario, options: Options, team: Team, home: Vector
) -> tuple[list[Figure], Table]:
    """Return the figures of further targets, and a row for each of them."""
    hair, jerk, back = [], [], []
    for number in range(options.cases):
        rng = np.random.default_rng([options.seed, 1000, number])
        beyond = _HAIR if number == 0 else float(10.0 ** rng.uniform(-4.0, -1.3))
        hair.append(run(resolved, straight_up(beyond, team, home), "lexstack", 10.0))
        case = out_of_reach(_KINDS[number % len(_KINDS)], rng, team, home)
        jerk.append(run(resolved, case, "lexstack", 10.0, jerk=True))
        case = out_of_reach(_KINDS[number % len(_KINDS)], rng, team, home)
        back.append(run(resolved, case, "lexstack", _AWAY, _BACK))
    options.say(f"{options.cases} each: a hair out of reach, jerk limits, and back home")
    ends = [_end(motion) for motion in back]
    rows = [_row("a hair beyond", motion) for motion in hair]
    rows += [_row("jerk limits", motion) for motion in jerk]
    rows += [
        (*_row("back home", motion)[:5], end, *_row("back home", motion)[6:])
        for motion, end in zip(back, ends, strict=True)
    ]
    figures = [
        Figure("0.1 mm to 50 mm out of reach: at rest within 10 s", _resting(hair), "%",
               Goal(">=", 98.0)),
        Figure("With jerk limits: at rest within 10 s", _resting(jerk), "%", Goal(">=", 98.0)),
        Figure("Back within reach: home within 6 s, or at a local minimum",
               100.0 * float(np.mean([end <= _LEAST for end in ends])), "%", Goal("==", 100.0)),
        Figure("Back within reach: home within 6 s",
               100.0 * float(np.mean([_is_home(motion) for motion in back])), "%"),
    ]  # fmt: skip
    return figures, Table(_COLUMNS, tuple(rows), "further targets")


def _resting(motions: list[Motion]) -> float:
    """Return which share is at rest at the end, %."""
    return 100.0 * float(np.mean([motion.rest_after() is not None for motion in motions]))


def _home_case(motion: Motion) -> Case:
    """Return the case whose targets are where the tools began."""
    return replace(motion.case, tools=motion.team.tools(motion.q[0]))


def _is_home(motion: Motion) -> bool:
    """Return whether the tools are where they began."""
    error, _ = errors(_home_case(motion), motion.team, motion.q[-1])
    return bool(np.abs(error).max() <= _HOME)


def _end(motion: Motion) -> float:
    """Return how far half the squared error is above the least one nearby [m^2]; home: 0."""
    if _is_home(motion):
        return 0.0
    return gap(_home_case(motion), motion.team, motion.q[-1])


def _row(what: str, motion: Motion) -> tuple[Cell, ...]:
    """Return what a run came to."""
    limits = motion.team.limits.acceleration * motion.team.dt
    steepest = float((np.abs(np.diff(motion.chi, axis=0)) / limits).max())
    told = sum(bool(command.near) for command in motion.commands)
    case = motion.case
    seen = (motion.rest_after(), motion.sign_changes(3.0), motion.excess(), steepest, told)
    return (what, case.kind, case.beyond, *seen)
