"""What each level of a phase's stack leaves at its end, and what keeps it from being met.

These are figures of every task, also of those that have no error in mm: posture, minimum velocity,
tasks of a user's own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import LexstackError
from lexstack.hqp import Blocked, HqpProblem, Solution, Status, explain_unmet_levels
from lexstack.limits import Bounds
from lexstack.robots import Team
from lexstack.tasks import Stack, build_stack
from lexstack.types import LinearTask, RobotState, Vector
from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import COMMANDER, TimeSeries, finite
from lexstack_bag.run.run import Run

_MOST = 20  # states at which the residuals of a phase are taken
UNMET = 1e-4
"""m/s, rad/s: a level that leaves less is met, as far as a reader is concerned."""

_SAME = 1e-6  # m/s, rad/s: bounds are recorded in single precision
_STRONGEST = 3  # of what holds a level back, so many are named

Levels = tuple[tuple[LinearTask, ...], ...]


@dataclass(frozen=True, slots=True)
class LevelMetrics:
    """One level of a stack in the steady state of a phase.

    Attributes:
        level: from 1, the highest priority.
        residual: mean 2-norm of the residual by task, in the unit of the task's rows (m/s, rad/s).
        held_by: what keeps the level from being met in the last state, the strongest first:
            "level 1: robot_a/ee_pose", "upper bound of robot_a/joint1"; empty where it is met.
    """

    level: int
    residual: dict[str, float | None]
    held_by: tuple[str, ...]


def levels_of(
    run: Run, team: Team, time_series: TimeSeries, phase: Phase, steady: NDArray[np.bool_]
) -> tuple[LevelMetrics, ...]:
    """Return the levels of a phase's stack; none where the bag cannot tell.

    Args:
        run: the run.
        team: its robots.
        time_series: its time series.
        phase: the phase.
        steady: which of the plant's states make its steady state, shape (T,).
    """
    stack = stack_of(run, team, phase)
    rows, commands = _common(run, np.flatnonzero(steady))
    if stack is None or not len(rows):
        return ()
    chosen = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), _MOST)).astype(int))
    chi = run.chi[COMMANDER].chi
    sums: dict[str, list[float]] = {}
    levels: Levels = ()
    for place in chosen.tolist():
        levels = linear_levels(run, team, time_series, stack, int(rows[place]))
        for task in (task for level in levels for task in level):
            residual = task.residual(chi[commands[place]])
            sums.setdefault(task.name, []).append(float(np.linalg.norm(residual)))
    obstacles = _held(run, team, levels, int(commands[chosen[-1]]))
    return tuple(
        LevelMetrics(
            k + 1,
            {task.name: finite(np.mean(sums[task.name])) for task in level},
            obstacles.get(k, ()),
        )
        for k, level in enumerate(levels)
    )


def stack_of(run: Run, team: Team, phase: Phase) -> Stack | None:
    """Return the stack of a phase for its robots; None where the bag's scenario has none."""
    config = run.resolved.stacks.get(phase.stack)
    if config is None:
        return None
    try:
        stack = build_stack(config, team)
    except LexstackError:  # it does not fit these robots, so nobody was on it
        return None
    if phase.robots:
        stack = stack.of(tuple(sorted(team.index(n) for n in phase.robots if n in team.names)))
    return None if stack.planned else stack


def _common(run: Run, rows: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return which of the plant's rows have a usable command, and the rows of these commands."""
    command = run.chi[COMMANDER]
    usable = np.isfinite(command.chi).all(axis=1)
    _, mine, theirs = np.intersect1d(
        run.plant.tick[rows], command.tick[usable], assume_unique=True, return_indices=True
    )
    return rows[mine], np.flatnonzero(usable)[theirs]


def linear_levels(run: Run, team: Team, time_series: TimeSeries, stack: Stack, row: int) -> Levels:
    """Return the levels of a stack, made linear as the controller did at a state of the plant."""
    plant = run.plant
    vectors = (plant.q[row], plant.v[row], plant.q_star[row], plant.command[row])
    state = RobotState(int(plant.tick[row]), float(plant.stamp[row]), *vectors)
    return stack.linearise(team.kinematics(state), time_series.references[row])


def _held(run: Run, team: Team, levels: Levels, command: int) -> dict[int, tuple[str, ...]]:
    """Return by level what holds it back at a row of the command, in words."""
    sent = run.chi[COMMANDER]
    chi = sent.chi[command]
    if not _is_optimum(levels, chi, sent.slacks[command]):
        return {}
    lower, upper = (_at(bound[command], chi) for bound in (sent.lower, sent.upper))
    if not (np.isfinite(chi).all() and (lower <= chi).all() and (chi <= upper).all()):
        return {}
    nothing = np.zeros(chi.size, dtype=np.int8)
    solution = Solution(chi, np.zeros(len(levels)), Status.SOLVED, "", nothing, 0.0)
    problem = HqpProblem(levels, Bounds(lower, upper))
    found = explain_unmet_levels(problem, solution, UNMET)
    return {each.level: _words(each, team.joint_names) for each in found}


def _is_optimum(levels: Levels, chi: Vector, slacks: Vector) -> bool:
    """Return whether chi is what the controller solved these levels to, by the slacks that it sent.

    It is not in a blend, where a fallback stood in, and where the robots are on several stacks.
    """
    left = [
        np.sqrt(sum(float(r @ r) for r in (t.residual(chi) for t in level))) for level in levels
    ]
    told = slacks[np.isfinite(slacks)]
    return len(told) == len(left) and bool(np.allclose(left, told, rtol=1e-3, atol=_SAME))


def _at(bound: NDArray[np.float32], chi: Vector) -> Vector:
    """Return a recorded bound, shape (n,), at chi where chi touches it."""
    exact = bound.astype(np.float64)
    return np.where(np.isnan(exact) | (np.abs(exact - chi) <= _SAME), chi, exact)


def _words(level: Blocked, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return what holds a level back, each thing once, the strongest first."""
    words = dict.fromkeys(
        f"{'upper' if each.side > 0 else 'lower'} bound of {names[each.joint]}"
        if each.joint >= 0
        else f"level {each.level + 1}: {each.task}"
        for each in level.obstacles
    )
    if not words:
        return ("no bound: its rows contradict each other",)
    more = len(words) - _STRONGEST
    return (*list(words)[:_STRONGEST], *([f"{more} more"] if more > 0 else []))
