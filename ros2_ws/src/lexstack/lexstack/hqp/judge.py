"""Which way a held joint or row is pressed: the sign of the first force on it that is not zero.

A force that should be zero is computed as rounding. What rounding makes grows with the numbers that
went into it: the length of chi, the targets, the multipliers. So it is these that decide what is
zero, and not one number for all problems.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.hqp.chain import Step
from lexstack.hqp.hierarchy import MULTIPLIER, Signs, noise
from lexstack.hqp.scaling import Bands
from lexstack.types import Matrix, Vector


@dataclass(slots=True)
class Balance:
    """How the forces of a chain came about.

    Attributes:
        steps: of the chain, from the highest level on.
        chi: shape (n,).
        sweep: the multipliers of the gradients below each step, from the lowest step on.
        bands: how the levels were divided, if they were.
    """

    steps: Sequence[Step]
    chi: Vector
    sweep: list[Matrix]
    bands: Bands | None

    def zeros(self) -> Vector:
        """Return below which size the forces of each step, and the last ones, are zero."""
        length = math.sqrt(self.chi.dot(self.chi))
        count = len(self.steps)
        magnitude = np.empty(count + 1)
        magnitude[count] = length
        for j in range(count - 1, -1, -1):
            step = self.steps[j]
            size = math.sqrt(np.vdot(step.rows, step.rows)) or 1.0
            goal = math.sqrt(step.target.dot(step.target))
            magnitude[j] = max(size, 1.0) * (size * length + goal)
            multipliers = np.abs(self.sweep[count - 1 - j]).sum(axis=1)
            magnitude[j + 1 :] += size * multipliers
        zeros: Vector = np.maximum(MULTIPLIER, noise(1.0) * magnitude)
        return zeros

    def of_levels(self, forces: Matrix) -> Matrix:
        """Return forces of steps, zeros made zero, as those of levels: the sum of their bands'."""
        forces = np.where(np.abs(forces) > self.zeros()[:, None], forces, 0.0)
        if self.bands is None or not self.bands.several:
            return forces
        total = np.zeros_like(forces)
        weight, owner, row = 1.0, -1, -1
        for step, force in zip(self.steps, forces, strict=False):
            own = -1 if step.level < 0 else self.bands.owner[step.level]
            if own < 0 or own != owner:
                owner, row = own, row + 1
                weight = 1.0 if own < 0 else self.bands.weight[step.level]
            ratio = 1.0 if own < 0 else self.bands.weight[step.level] / weight
            total[row] += ratio * ratio * force
        total[row + 1] = forces[-1]
        return total


def judge(sides: Signs, judged: Signs, forces: Matrix, balance: Balance) -> int:
    """Release what is pulled by the first force on it that is not zero; return how many are.

    Args:
        sides: shape (m,), of joints or of rows; zero where released.
        judged: those that may be released, shape (m,).
        forces: outward, in the order of the steps, shape (steps + 1, m).
        balance: where they come from.
    """
    pressed = forces * judged
    flat = pressed.reshape(-1)
    if not flat.size or flat.item(flat.argmin()) >= -MULTIPLIER:  # four times as fast as min()
        return 0  # mostly; the order of the levels matters where some pull and some press
    felt = balance.of_levels(pressed)
    first = felt[(felt != 0.0).argmax(axis=0), np.arange(judged.size)]
    pulled = first < 0.0
    sides[pulled] = 0
    return int(np.count_nonzero(pulled))
