"""Why a level is not met: which bounds and which rows of higher levels stand in its way.

At the optimum of level k the gradient of its slack s = ||A_k chi - b|| is held by forces from what
chi must not leave,

    -grad s = sum lambda_i e_i + sum mu_j a_j

lambda_i on the joints at their bounds, pressing outward; mu_j on the rows of the levels above. A
force says how much the slack falls when its bound or row gives way by one unit. This is computed
when somebody asks, never in a tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.hqp.problem import HqpProblem, Solution
from lexstack.hqp.scipy_parts import nnls
from lexstack.types import LinearTask, Matrix, Vector

UNMET = 1e-6  # in the unit of a level: a smaller slack is met
_TOUCH = 1e-9  # nearer than this to its end, a joint or row may be pressed
_NAMED = 4  # levels, and obstacles of each, that a line names
_MOST_STEPS = 30  # of the search for forces, per force
_FELT = 1e-6  # of the largest force: smaller ones are left out


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A bound of a joint, or a row of a higher level, that holds a level back.

    Attributes:
        force: how much the level's slack falls when this gives way by one unit, positive.
        side: where it would have to give way: +1 upward, -1 downward.
        joint: place in chi, or -1 for a row.
        level: of the row, or -1 for a joint.
        task: of the row, or ''.
        row: of the task, or -1.
    """

    force: float
    side: int
    joint: int = -1
    level: int = -1
    task: str = ""
    row: int = -1


@dataclass(frozen=True, slots=True)
class Blocked:
    """A level that is not met.

    Attributes:
        level: index 0 is the highest.
        slack: norm of its residual.
        task: of its row that misses most.
        row: that row of the task.
        residual: by which it misses, with its sign.
        obstacles: what is in the way, the strongest first; empty where the level contradicts
            itself, or asks for a direction that the robot does not have.
    """

    level: int
    slack: float
    task: str
    row: int
    residual: float
    obstacles: tuple[Obstacle, ...]


@dataclass(slots=True)
class _Row:
    """A row of a level above: where it stands, its coefficients, and which force it may bear."""

    level: int
    task: str
    row: int
    coefficients: Vector
    least: float
    most: float


def explain_unmet_levels(
    problem: HqpProblem, solution: Solution, threshold: float = UNMET
) -> tuple[Blocked, ...]:
    """Return the levels whose slack is above ``threshold``, with what stands in their way.

    Args:
        problem: with the bounds.
        solution: of it, solved.
        threshold: in the unit of the levels.
    """
    above: list[_Row] = []
    found = []
    for k, level in enumerate(problem.levels):
        residuals = [task.residual(solution.chi) for task in level]
        slack = float(np.sqrt(sum(float(r @ r) for r in residuals)))
        if slack > threshold:
            gradient = sum(
                (r @ task.matrix for r, task in zip(residuals, level, strict=True)),
                np.zeros(solution.chi.size),
            )
            obstacles = _obstacles(gradient / slack, problem, solution.chi, above)
            found.append(Blocked(k, slack, *_worst(level, residuals), obstacles))
        for task, residual in zip(level, residuals, strict=True):
            above += _rows(k, task, solution.chi, residual)
    return tuple(found)


def describe(levels: Sequence[Blocked], joint_names: Sequence[str]) -> str:
    """Return one line in words, not long, empty where every level is met.

    Levels and rows are counted from 1 in it.

    Args:
        levels: as ``explain_unmet_levels`` returns them.
        joint_names: of all joints in the order of chi.
    """
    return "; ".join(_shortened([_sentence(level, joint_names) for level in levels]))


def _sentence(level: Blocked, joint_names: Sequence[str]) -> str:
    """Return what holds one level back, in words."""
    what = f"level {level.level + 1}: {level.task} row {level.row + 1}"
    missed = f"{what} misses by {level.residual:.3g}"
    if not level.obstacles:
        return f"{missed}: no bound is in the way, its rows cannot all be met"
    words = []
    for obstacle in level.obstacles:
        where = "upper" if obstacle.side > 0 else "lower"
        name = (
            f"{where} bound of {joint_names[obstacle.joint]}"
            if obstacle.joint >= 0
            else f"{obstacle.task} row {obstacle.row + 1} of level {obstacle.level + 1}"
        )
        words.append(f"{name} ({obstacle.force:.2g})")
    return f"{missed}, held by {', '.join(_shortened(words))}"


def _shortened(words: list[str]) -> list[str]:
    """Return the first words, and how many more there are: the line is read by people."""
    more = len(words) - _NAMED
    return words if more <= 0 else [*words[:_NAMED], f"… and {more} more"]


def _worst(level: tuple[LinearTask, ...], residuals: list[Vector]) -> tuple[str, int, float]:
    """Return the task, the row and the residual of the row that misses most."""
    sizes = [float(np.abs(r).max(initial=0.0)) for r in residuals]
    place = int(np.argmax(sizes))
    row = int(np.argmax(np.abs(residuals[place])))
    return level[place].name, row, float(residuals[place][row])


def _rows(level: int, task: LinearTask, chi: Vector, residual: Vector) -> list[_Row]:
    """Return the rows of a task that bind the levels below it, with the forces they may bear."""
    value = task.matrix @ chi
    most = np.where(task.upper - value < _TOUCH, np.inf, 0.0)
    least = np.where(value - task.lower < _TOUCH, -np.inf, 0.0)
    broken = np.abs(residual) > _TOUCH  # stays as it is, so it binds in both directions
    most[broken], least[broken] = np.inf, -np.inf
    return [
        _Row(level, task.name, int(i), task.matrix[i], float(least[i]), float(most[i]))
        for i in np.flatnonzero((least < 0.0) | (most > 0.0))
    ]


def _obstacles(
    gradient: Vector, problem: HqpProblem, chi: Vector, above: list[_Row]
) -> tuple[Obstacle, ...]:
    """Return the forces that hold a gradient, the strongest first."""
    most = np.where(problem.bounds.upper - chi < _TOUCH, np.inf, 0.0)
    least = np.where(chi - problem.bounds.lower < _TOUCH, -np.inf, 0.0)
    joints = np.flatnonzero((least < 0.0) | (most > 0.0))
    columns = np.vstack(
        [np.eye(chi.size)[joints], *(row.coefficients[None] for row in above)],
    ).T
    limits = (
        np.concatenate([least[joints], [row.least for row in above]]),
        np.concatenate([most[joints], [row.most for row in above]]),
    )
    if not columns.shape[1] or float(np.abs(gradient).max(initial=0.0)) < _TOUCH:
        return ()
    forces = _forces(columns, -gradient, limits)
    obstacles = [
        Obstacle(abs(f), _sign(f), joint=int(j))
        for f, j in zip(forces[: joints.size], joints, strict=True)
    ]
    obstacles += [
        Obstacle(abs(f), _sign(f), -1, row.level, row.task, row.row)
        for f, row in zip(forces[joints.size :], above, strict=True)
    ]
    least_felt = _FELT * max(obstacle.force for obstacle in obstacles)
    felt = [obstacle for obstacle in obstacles if obstacle.force > max(least_felt, _TOUCH)]
    return tuple(sorted(felt, key=lambda obstacle: -obstacle.force))


def _forces(columns: Matrix, target: Vector, limits: tuple[Vector, Vector]) -> Vector:
    """Return the forces with the right signs that hold the target best, shape (columns,)."""
    plain = np.linalg.lstsq(columns, target, rcond=1e-10)[0]
    if (plain >= limits[0] - _TOUCH).all() and (plain <= limits[1] + _TOUCH).all():
        return plain.astype(float)
    # Each force has one sign, or any: a free one is the difference of two that are not negative.
    # scipy's lsq_linear multiplies infinite limits by zero here, and warns of it.
    size = columns.shape[1]
    falls, rises = np.flatnonzero(limits[0] < 0.0), np.flatnonzero(limits[1] > 0.0)
    signed = np.hstack([columns[:, rises], -columns[:, falls]])
    try:
        parts = nnls(signed, target, _MOST_STEPS * max(size, 1))
    except RuntimeError:  # too many steps: the right signs matter more than the last digit
        return np.clip(plain, *limits)
    found = np.zeros(size)
    found[rises] += parts[: rises.size]
    found[falls] -= parts[rises.size :]
    return found


def _sign(force: float) -> int:
    """Return the side to which a force presses."""
    return 1 if force > 0.0 else -1
