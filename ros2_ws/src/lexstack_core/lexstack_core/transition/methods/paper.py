"""The two methods that paper T prints."""

from __future__ import annotations

from lexstack_core.bounds import Bounds
from lexstack_core.hqp import HqpProblem
from lexstack_core.transition.bridge import Bridge
from lexstack_core.transition.methods.view import View, below


def t37(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return T(37): level 1, then the source, within ``alpha`` times the box of T(35).

    As printed: at alpha = 0 the box is the point 0, so whatever moves stops at once, beyond every
    acceleration limit. Where the box excludes 0 (outside a position limit) it is kept whole.
    """
    box = view.free()
    lower = alpha * box.lower.clip(max=0.0) + box.lower.clip(min=0.0)
    upper = alpha * box.upper.clip(min=0.0) + box.upper.clip(max=0.0)
    levels = below(view.first, view.part.follow(view.source))
    return HqpProblem(levels, Bounds(lower, upper))


def t34(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return T(34): level 1, then the source, in a box that goes from the last tick's to the new.

    Where the limits do not change, neither does the box: the method then has no effect.
    """
    new, old = view.free(), view.before
    lower = alpha * new.lower + (1.0 - alpha) * old.lower
    upper = alpha * new.upper + (1.0 - alpha) * old.upper
    levels = below(view.first, view.part.follow(view.source))
    return HqpProblem(levels, Bounds(lower, upper))
