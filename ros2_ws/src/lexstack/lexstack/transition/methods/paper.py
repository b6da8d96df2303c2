"""The two methods that paper T prints, one of them in two readings."""

from __future__ import annotations

import numpy as np

from lexstack.hqp import HqpProblem
from lexstack.limits.joint_limits import Bounds
from lexstack.transition.bridge import Bridge
from lexstack.transition.methods.view import View, below


def t37(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return T(37): level 1, then the source, within ``alpha`` times the box of T(35).

    As printed: at alpha = 0 the box is the point 0, so whatever moves stops at once, beyond every
    acceleration limit. Where the box excludes 0 (outside a position limit) it is kept whole.
    """
    box = view.context.free_bounds()
    lower = alpha * box.lower.clip(max=0.0) + box.lower.clip(min=0.0)
    upper = alpha * box.upper.clip(min=0.0) + box.upper.clip(max=0.0)
    levels = below(view.first, view.group.follow(view.source))
    return HqpProblem(levels, Bounds(lower, upper))


def t34(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return T(34): level 1, then the source, in a box that goes from the last tick's to the new.

    The new box is that of T(35), without acceleration limits, as in the solver. Where the limits
    do not change, neither does the box: the method then has no effect.
    """
    levels = below(view.first, view.group.follow(view.source))
    return HqpProblem(
        levels, _between(view.context.bounds_before, view.context.free_bounds(), alpha)
    )


def t34_limited(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return T(34) read in its strongest form: with the acceleration limits of T(31) in both boxes.

    The new box is the command's, and the blend stays in it: it is never empty, and every change of
    the command stays within the acceleration limits.
    """
    box, own = _between(view.context.bounds_before, view.context.bounds, alpha), view.context.bounds
    lower = np.clip(box.lower, own.lower, own.upper)
    upper = np.clip(box.upper, own.lower, own.upper)
    levels = below(view.first, view.group.follow(view.source))
    return HqpProblem(levels, Bounds(lower, upper))


def _between(old: Bounds, new: Bounds, alpha: float) -> Bounds:
    """Return the box alpha new + (1 - alpha) old."""
    lower = alpha * new.lower + (1.0 - alpha) * old.lower
    upper = alpha * new.upper + (1.0 - alpha) * old.upper
    return Bounds(lower, upper)
