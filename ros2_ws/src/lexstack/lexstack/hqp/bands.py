"""The rows of a level in bands of different size: what the large ones give way to the small ones.

A level minimises sum_b w_b^2 ||E_b chi - t_b||^2, with E_b the rows of band b, divided by w_b.
Solved like levels, the bands give the limit in which every w_b is infinitely larger than the next
one. At the true optimum the gradients balance in the directions that band b sees,

    w_b^2 E_b' (E_b chi - t_b) + sum over c below b: w_c^2 E_b' mu_cb = 0,

with mu_cb the multipliers of band c on the rows of band b. So band b is solved for the target
t_b - sum_c (w_c / w_b)^2 mu_cb, again and again until nothing changes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lexstack.hqp.chain import Step
from lexstack.hqp.scaling import Bands
from lexstack.types import Vector

_PASSES = 60
_SETTLED = 8.0 * float(np.finfo(float).eps)


def settle(steps: Sequence[Step], bands: Bands, begin: Vector, chi: Vector) -> bool:
    """Move chi from the limit to the optimum of the levels as given; return whether it came there.

    Args:
        steps: of the chain; the targets of bands are left as they have to be.
        bands: how the levels were divided.
        begin: where the chain begins, shape (n,).
        chi: where it ended, shape (n,); moved in place.
    """
    several = [group for group in _groups(steps, bands) if len(group) > 1]
    if not several:
        return True
    own = [[step.target for step in group] for group in several]
    for _ in range(_PASSES):
        before = chi.copy()
        for group, targets in zip(several, own, strict=True):
            _give_way(group, targets, bands, chi)
        chi[:] = begin
        for step in steps:
            step.move(chi)
        change = float(np.abs(chi - before).max(initial=0.0))
        if not math.isfinite(change):
            return False
        if change <= _SETTLED * float(np.abs(chi).max(initial=0.0)):
            return True
    return False


def _groups(steps: Sequence[Step], bands: Bands) -> list[list[Step]]:
    """Return the steps of each level."""
    groups: dict[int, list[Step]] = {}
    for step in steps:
        if step.level >= 0:
            groups.setdefault(bands.owner[step.level], []).append(step)
    return list(groups.values())


def _give_way(group: Sequence[Step], targets: list[Vector], bands: Bands, chi: Vector) -> None:
    """Set the targets of a level's bands to what those below them leave of their own."""
    shifts = [np.zeros(target.size) for target in targets]
    for c in range(len(group) - 1, 0, -1):
        small = group[c]
        gradient = ((small.rows.dot(chi) - small.target).dot(small.rows))[None]
        for b in range(c - 1, -1, -1):
            large = group[b]
            multipliers = large.balanced(gradient)
            gradient = gradient - multipliers.dot(large.rows)
            ratio = bands.weight[small.level] / bands.weight[large.level]
            shifts[b] += ratio * ratio * multipliers[0]
    for step, target, shift in zip(group, targets, shifts, strict=True):
        step.target = target - shift
