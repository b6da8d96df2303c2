"""Variables of any unit: columns brought to one size by powers of two, which round nothing.

With chi_j = 2^s_j y_j the columns of y are the columns of chi times 2^s_j. The same problem is then
asked of y: rows and box are those of chi, and what no level uses still goes into the smallest
||chi||, which stands as one more level, 2^s_j y_j -> 0, as ||y|| would mean another one.

Robots never need it: a short column of a Jacobian is a joint that loses its hold, and no unit.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lexstack.hqp.hierarchy import Hierarchy
from lexstack.hqp.problem import HqpProblem, Solution
from lexstack.limits.viable_bounds import Bounds
from lexstack.types import LinearTask, Vector

Powers = NDArray[np.intp]

# Exponents of two: columns whose sizes lie within this are taken as they are.
_SPREAD = 10
_PASSES = 20  # of the equilibration of rows and columns
# Entries beyond it are rounding, or too large to be weighed.
_LEAST, _LARGEST = 2.0**-300, 2.0**300


def column_powers(hierarchy: Hierarchy, problem: HqpProblem) -> Powers | None:
    """Return the s_j of each variable, shape (n,), or None where the columns are of about one size.

    Args:
        hierarchy: of the problem's levels, as given.
        problem: with its tasks; one with a Jacobian among them is taken as it is.
    """
    if any(task.curve is not None for level in problem.levels for task in level):
        return None
    sizes = np.abs(hierarchy.matrix)
    largest = sizes.max(axis=0, initial=0.0)
    used = largest > _LEAST
    if not used.any() or not largest.max() < _LARGEST:
        return None
    if largest.max() < 2.0**_SPREAD * largest[used].min():
        return None
    # Large rows hide what is in small ones: an entry is the size of its row times its column's.
    known = sizes > _LEAST
    logs = np.log2(sizes, out=np.zeros_like(sizes), where=known)
    rows, columns = known.sum(axis=1), known.sum(axis=0)
    column = np.zeros(largest.size)
    for _ in range(_PASSES):
        row = (logs - column * known).sum(axis=1) / np.maximum(rows, 1)
        column = (logs - row[:, None] * known).sum(axis=0) / np.maximum(columns, 1)
    if np.ptp(column[used]) < _SPREAD:
        return None
    column = np.where(used, column - np.median(column[used]), 0.0)
    return -np.rint(column).astype(np.intp)


def scaled_columns(problem: HqpProblem, powers: Powers) -> HqpProblem:
    """Return the problem of y, with the smallest ||chi|| as its last level.

    Args:
        problem: of chi.
        powers: s_j, shape (n,).
    """
    levels = tuple(
        tuple(
            LinearTask(task.name, np.ldexp(task.matrix, powers), task.lower, task.upper)
            for task in level
        )
        for level in problem.levels
    )
    n = powers.size
    smallest = LinearTask.equality("smallest", np.diag(np.ldexp(np.ones(n), powers)), np.zeros(n))
    lower, upper = (np.ldexp(end, -powers) for end in (problem.bounds.lower, problem.bounds.upper))
    return HqpProblem((*levels, (smallest,)), Bounds(lower, upper))


def warm_columns(warm: Solution | None, n: int) -> Solution | None:
    """Return what a solution of chi (n,) says of y."""
    if warm is None or not warm.rows.size:
        return warm
    return replace(warm, rows=np.concatenate([warm.rows, np.zeros(n, dtype=np.int8)]))


def restored_columns(
    solution: Solution, powers: Powers, hierarchy: Hierarchy, bounds: Bounds
) -> Solution:
    """Return the solution of chi.

    Args:
        solution: of y, with the level of the smallest ||chi||.
        powers: s_j, shape (n,).
        hierarchy: of the levels as given.
        bounds: of chi.
    """
    chi: Vector = np.ldexp(solution.chi, powers)
    chi = np.minimum(np.maximum(chi, bounds.lower), bounds.upper)
    slacks = hierarchy.slacks(hierarchy.residual(chi))
    rows = solution.rows[: hierarchy.lower.size]
    for array in (chi, slacks, rows):
        array.setflags(write=False)
    return replace(solution, chi=chi, slacks=slacks, rows=rows)
