"""The levels of one robot as arrays, for the compiled test of ``kernel/regular``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.hqp.groups import Group
from lexstack.hqp.kernel.values import Places
from lexstack.hqp.problem import HqpProblem
from lexstack.robots import Kinematics
from lexstack.types import LinearTask, Vector


@dataclass(frozen=True, slots=True, eq=False)
class ChainLevels:
    """A pose of one robot, then levels that are linear in its joints: what does not change of it.

    Attributes:
        columns: of the robot in chi.
        robot: its place in the team.
        places: level and place of each task, with 1 / K.
        ends: one past the last row of each level.
        scales: roots of the weights, by level.
        sign: of the pose's rows.
    """

    columns: slice
    robot: int
    places: tuple[tuple[int, int, float], ...]
    ends: Places
    scales: Vector
    sign: float

    @classmethod
    def of(cls, group: Group, problem: HqpProblem) -> ChainLevels | None:
        """Return them for a group whose tasks all have a curve; None where they are others."""
        levels: list[list[LinearTask]] = [
            [problem.levels[rank][place] for place in places]
            for rank, places in zip(group.ranks, group.tasks, strict=True)
        ]
        curves = [[task.curve for task in level if task.curve is not None] for level in levels]
        if len(group.places) != 1 or not isinstance(group.columns, slice) or len(curves[0]) != 1:
            return None
        first = curves[0][0]
        below = [curve for level in curves[1:] for curve in level]
        if len(first.signs) != 1 or any(curve.signs for curve in below):
            return None
        places = [
            (rank, place)
            for rank, chosen in zip(group.ranks, group.tasks, strict=True)
            for place in chosen
        ]
        gains = [1.0 / curve.gain for level in curves for curve in level]
        return cls(
            group.columns,
            first.robots[0],
            tuple([(*place, gain) for place, gain in zip(places, gains, strict=True)]),
            np.cumsum([sum(task.lower.size for task in level) for level in levels]),
            np.array([max(curve.scale for curve in level) for level in curves]),
            first.signs[0],
        )

    def regular(self, problem: HqpProblem, kinematics: Kinematics, kernel: Any) -> bool:
        """Return whether all levels are regular; where it is False, others have to look.

        Args:
            problem: of the same tasks, and no joint of the robot stands at a position limit.
            kinematics: of this tick.
            kernel: the module ``kernel.regular``.
        """
        rows, errors = [], []
        for rank, place, factor in self.places:
            task = problem.levels[rank][place]
            if task.frame is not None:
                return False
            rows.append(task.matrix[:, self.columns])
            errors.append(factor * task.correction)
        if self.robot in kinematics.unicycles:
            return False
        axes = kinematics.jacobians[self.robot][3:]
        matrix, error = np.concatenate(rows, dtype=float), np.concatenate(errors, dtype=float)
        if error.size != self.ends[-1] or axes.shape[1] != matrix.shape[1]:
            return False
        return bool(kernel.regular(matrix, error, self.ends, self.scales, axes, self.sign))
