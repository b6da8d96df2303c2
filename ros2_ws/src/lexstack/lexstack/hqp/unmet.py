"""From the optimum of bands solved like levels to that of the levels whose bands they are.

The cascade solves one band after the other, as if each were infinitely larger than the next one.
Where a level is met that is its optimum. Where it is not, the chain of `active_set.py` finds the
optimum from the active set of the cascade's; and if it does not, the answer is refused, except
where the bands differ so much that nobody could tell.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.hqp.active_set import (
    WorkingSet,
    hold,
    hold_fixed,
    point_of,
    release,
    solve_by_active_set,
)
from lexstack.hqp.hierarchy import FEASIBILITY, Hierarchy, Mask, Signs, noise
from lexstack.hqp.scaling import Bands
from lexstack.types import Vector

_ROUNDS = 10
_SINGLE_ROUNDS = 300
# A large band gives way to a small one by so little that the active set may not be resolved.
_NEARLY = 1e-9
_ENORMOUS = 2.0**17  # its square is the share by which a small band moves a large one


def with_weights(
    hierarchy: Hierarchy, bands: Bands, box: tuple[Vector, Vector], chi: Vector
) -> tuple[Vector, int]:
    """Return the optimum of the levels as given, and -1; or ``chi`` and the level that is not.

    Args:
        hierarchy: scaled.
        bands: how; a level has several.
        box: bounds of chi, shapes (n,).
        chi: the optimum of the bands as levels, shape (n,).
    """
    unmet = _unmet(hierarchy, bands, chi)
    if unmet < 0:
        return chi, -1
    lower, upper = box
    near = max(FEASIBILITY, noise(math.sqrt(chi.dot(chi))))
    joints: Signs = np.zeros(chi.size, dtype=np.int8)
    joints[chi - lower <= near] = -1
    joints[upper - chi <= near] = 1
    working_set = WorkingSet(joints, hierarchy.active_bounds(chi))
    careful = working_set.copy()
    found = solve_by_active_set(hierarchy, lower, upper, working_set, _ROUNDS, bands=bands)
    if found is None:
        found = _one_by_one(hierarchy, bands, box, careful)
    if found is not None:
        return np.minimum(np.maximum(found, lower), upper), -1
    if bands.gap() >= _ENORMOUS:
        return chi, -1
    return chi, unmet


def _one_by_one(
    hierarchy: Hierarchy, bands: Bands, box: tuple[Vector, Vector], working_set: WorkingSet
) -> Vector | None:
    """Return the optimum, found by changing only the first wrong place of each working set.

    Murty's rule of the least index: it takes longer, and it cannot cycle. What a large band gives
    way may be too little for the sign of a force to be seen. But a joint that leaves the box as
    soon as it alone is released was held rightly, and is not judged until something else changes.
    """
    fixed = hold_fixed(working_set, *box)
    kept: Mask = np.zeros(working_set.joints.size, dtype=np.bool_)
    last = -1
    for _ in range(_SINGLE_ROUNDS):
        chi, steps = point_of(hierarchy, *box, working_set, bands)
        if not math.isfinite(chi.dot(chi)):
            return None
        before = working_set.copy()
        wrong = hold(hierarchy, chi, box, working_set, _NEARLY)
        if steps is not None:
            unjudged = kept if fixed is None else kept | fixed
            wrong += release(hierarchy, steps, chi, working_set, unjudged, bands)
        if not wrong:
            return chi
        working_set.keep_first_change(before)
        changed = np.flatnonzero(working_set.joints != before.joints)
        joint = int(changed[0]) if changed.size else -1
        back = joint >= 0 and joint == last and working_set.joints[joint] != 0
        kept[:] = False
        if back:
            kept[joint] = True
        last = joint
    return None


def _unmet(hierarchy: Hierarchy, bands: Bands, chi: Vector) -> int:
    """Return the first level of several bands that is not met, or -1."""
    residual = np.abs(hierarchy.residual(chi))
    near = max(FEASIBILITY, noise(math.sqrt(chi.dot(chi))))
    for level, owner in zip(hierarchy.levels, bands.owner, strict=True):
        if bands.owner.count(owner) > 1 and residual[level.rows].max(initial=0.0) > near:
            return owner
    return -1
