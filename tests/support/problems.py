"""Hierarchies to test with: those of the bench of strictness, cut off and side by side."""

from __future__ import annotations

import numpy as np

from lexstack.hqp import HqpProblem
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from lexstack_experiments.hierarchies.random_problems import KINDS, near_singular, problem

__all__ = ["KINDS", "near_singular", "problem", "side_by_side", "truncated"]


def truncated(whole: HqpProblem, levels: int) -> HqpProblem:
    """Return the highest levels of a problem."""
    return HqpProblem(whole.levels[:levels], whole.bounds)


def side_by_side(problems: list[HqpProblem]) -> HqpProblem:
    """Return problems of equally many levels as one, whose chi is theirs one after the other.

    Nothing couples them: the optimum is theirs. The k-th levels are minimised together.
    """
    sizes = [part.bounds.lower.size for part in problems]
    starts = np.cumsum([0, *sizes])
    levels = []
    for k in range(len(problems[0].levels)):
        tasks = []
        for place, part in enumerate(problems):
            for task in part.levels[k]:
                matrix = np.zeros((task.lower.size, starts[-1]))
                matrix[:, starts[place] : starts[place + 1]] = task.matrix
                tasks.append(LinearTask(f"{place}/{task.name}", matrix, task.lower, task.upper))
        levels.append(tuple(tasks))
    lower = np.concatenate([part.bounds.lower for part in problems])
    upper = np.concatenate([part.bounds.upper for part in problems])
    return HqpProblem(tuple(levels), Bounds(lower, upper))
