"""Hierarchies as a controller meets them, and worse: seeded, with entries of natural size."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lexstack.hqp import HqpProblem
from lexstack.limits import Bounds
from lexstack.types import LinearTask, Matrix, Vector

KINDS = ("nominal", "tight", "deficient", "infeasible", "pinned")
SINGULAR = "near-singular"


def problems(seed: int, count: int) -> Iterator[tuple[str, HqpProblem]]:
    """Yield ``count`` problems with their kinds: all kinds in turn, with and without inequalities.

    Every tenth is near-singular; sizes are between 10 and 80 variables, small ones more often.
    """
    for i in range(count):
        rng = np.random.default_rng((seed, i))
        n = int(10.0 * 8.0 ** (rng.random() ** 1.5))
        if i % 10 == 9:
            rows = int(rng.integers(2, min(n - 2, 12)))
            exponent = rng.uniform(-16.0, -2.0)
            yield SINGULAR, near_singular(int(rng.integers(2**32)), n, rows, 10.0**exponent)
        else:
            kind = KINDS[i % 5]
            levels, inequalities = int(rng.integers(1, 6)), bool(i // 10 % 2)
            yield kind, problem(kind, int(rng.integers(2**32)), n, levels, inequalities)


def with_unit_rows(given: HqpProblem) -> HqpProblem:
    """Return a problem with every row divided by its length: another one where a level is not met.

    A level weighs its rows by their squared lengths; a solver that scales rows weighs them alike.
    """
    return HqpProblem(
        tuple(tuple(_unit(task) for task in level) for level in given.levels), given.bounds
    )


def _unit(task: LinearTask) -> LinearTask:
    """Return a task with rows of length 1; rows of zeros stay."""
    length = np.linalg.norm(task.matrix, axis=1)
    length[length == 0.0] = 1.0
    matrix = task.matrix / length[:, None]
    return LinearTask(task.name, matrix, task.lower / length, task.upper / length)


def problem(kind: str, seed: int, n: int, levels: int, inequalities: bool = False) -> HqpProblem:
    """Return a problem of n variables; entries of tasks are about 1, targets about 0.5.

    Args:
        kind: ``nominal``; ``tight``: acceleration boxes of +-0.02 around a previous velocity;
            ``deficient``: rows that depend on each other; ``infeasible``: level 0 asks for far
            more than the bounds allow; ``pinned``: some joints must not move.
        seed: of everything random in it.
        n: length of chi.
        levels: how many.
        inequalities: whether some rows are intervals, some of them without one end.
    """
    rng = np.random.default_rng(seed)
    tasks = []
    for k in range(levels):
        matrix = _matrix(rng, n, last=k == levels - 1)
        if kind == "deficient" and rng.random() < 0.7:
            rank = max(1, matrix.shape[0] - int(rng.integers(1, 4)))
            matrix[rank:] = rng.normal(size=(matrix.shape[0] - rank, rank)) @ matrix[:rank]
        target = 0.5 * rng.normal(size=matrix.shape[0])
        if kind == "infeasible" and k == 0:
            target *= 100.0
        lower, upper = target, target
        if inequalities and rng.random() < 0.6:
            lower, upper = _interval(rng, target)
        tasks.append((LinearTask(f"task_{k}", matrix, lower, upper),))
    return HqpProblem(tuple(tasks), _bounds(rng, kind, n))


def near_singular(seed: int, n: int, rows: int, smallest: float) -> HqpProblem:
    """Return one level of ``rows`` rows whose least singular value is ``smallest``, then two."""
    rng = np.random.default_rng(seed)
    left, values, right = np.linalg.svd(rng.normal(size=(rows, n)), full_matrices=False)
    values[-1] = smallest
    tasks = (
        LinearTask.equality("singular", (left * values) @ right, 0.5 * rng.normal(size=rows)),
        LinearTask.equality("second", rng.normal(size=(3, n)), 0.5 * rng.normal(size=3)),
        LinearTask.equality("follow", np.eye(n), 0.5 * rng.normal(size=n)),
    )
    return HqpProblem(tuple((task,) for task in tasks), _bounds(rng, "nominal", n))


def _matrix(rng: np.random.Generator, n: int, last: bool) -> Matrix:
    """Return rows as tasks have them: two Jacobians, a selection, all of chi, or anything."""
    form = rng.integers(4)
    if last and rng.random() < 0.5:
        return np.eye(n)
    if form == 0:
        half = n // 2
        rows = min(6, half)
        matrix = np.zeros((2 * rows, n))
        matrix[:rows, :half] = rng.normal(size=(rows, half))
        matrix[rows:, half:] = rng.normal(size=(rows, n - half))
        return matrix
    if form == 1:
        return np.eye(n)[rng.permutation(n)[: rng.integers(1, n)]]
    return rng.normal(size=(rng.integers(1, n), n))


def _interval(rng: np.random.Generator, target: Vector) -> tuple[Vector, Vector]:
    """Return intervals around a target: narrow, of width zero, or open on one side."""
    width = rng.uniform(0.0, 0.6, size=target.size) * (rng.random(target.size) < 0.7)
    lower, upper = target - width, target + width
    lower[rng.random(target.size) < 0.3] = -np.inf
    upper[(rng.random(target.size) < 0.3) & np.isfinite(lower)] = np.inf
    return lower, upper


def _bounds(rng: np.random.Generator, kind: str, n: int) -> Bounds:
    """Return bounds on chi; those of ``tight`` often leave zero out."""
    if kind == "tight":
        previous = 0.3 * rng.normal(size=n)
        return Bounds(previous - 0.02, previous + 0.02)
    width = rng.uniform(0.3, 2.5, size=n)
    if kind == "pinned":
        width[rng.permutation(n)[: n // 4]] = 0.0
    return Bounds(-width, width)
