"""How much a pose bends at most where a linear level below it pulls: known from a state nearby."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.hqp.curvature import add_curvature
from lexstack.hqp.lift import GroupLevel
from lexstack.robots import Kinematics

FIRM = 0.02  # least singular value of the rows above a level: with less nothing is known below
_POSE = 6  # rows
_ALL = slice(None)


@dataclass(frozen=True, slots=True)
class Bend:
    """How much one task bends, by the multipliers that a linear level below it has, per |e|.

    With X = (G G^T)^-1 G A^T and the projector P on the null space of G, P B(X e) P is looked at;
    at rows that differ by d from G it is larger by at most d times the terms of ``most``.

    Attributes:
        least: g, the least singular value of G.
        below: |A|.
        whole: |B(w)| / |w| at most.
        turn: by which that grows with d, at most.
        inside: |P B(X e) P| / |e| at most.
    """

    least: float
    below: float
    whole: float
    turn: float
    inside: float

    @classmethod
    def of(cls, levels: Sequence[GroupLevel], kinematics: Kinematics) -> Bend | None:
        """Return it for a level of one pose and a linear one below; None for others.

        Args:
            levels: these two, of one robot.
            kinematics: of this tick.
        """
        first, second = levels
        curve = first.tasks[0].curve
        if len(first.tasks) > 1 or curve is None or len(curve.signs) != 1 or second.curved:
            return None
        matrix = first.matrix
        if len(matrix) != _POSE or first.partial:
            return None
        joints = matrix.shape[1]
        bends = np.zeros((_POSE, joints, joints))
        for bend, weights in zip(bends, np.eye(_POSE), strict=True):
            add_curvature(bend, first.tasks[0], weights, kinematics, {curve.robots[0]: _ALL})
        u, values, vt = np.linalg.svd(matrix)
        inverse = (u / values).dot(vt[:_POSE])
        multipliers = inverse.dot(second.matrix.T)
        free = vt[_POSE:]
        seen = np.tensordot(multipliers, free.dot(bends).dot(free.T), (0, 1))
        rows = matrix / curve.scale
        linear, angular = float(np.linalg.norm(rows[:3])), float(np.linalg.norm(rows[3:]))
        return cls(
            float(values[-1]),
            float(np.linalg.norm(second.matrix, 2)),
            float(np.linalg.norm(bends.reshape(_POSE, -1), 2)),
            math.sqrt(2.0) * (linear + 2.0 * angular + 2.0 / curve.scale),
            float(np.linalg.norm(seen.reshape(len(seen), -1), 2)),
        )

    def most(self, moved: float) -> float:
        """Return |P B(X e) P| / |e| at most, the rows having moved by d.

        P moves by at most d / g, and X by 1.62 |A| d / (g g') with g' = g - d (Wedin).
        """
        least = self.least - moved
        if least <= FIRM or moved > 1.0:
            return math.inf
        whole = self.whole + self.turn * moved
        slope = (3.62 * whole / self.least + self.turn) * self.below / least
        return self.inside + slope * moved
