"""Interpolation of two solutions, after Lee, Mansard and Park 2012."""

from __future__ import annotations

from lexstack.hqp import HqpProblem
from lexstack.transition import Bridge, View


def interpolation(view: View, _latched: Bridge, alpha: float) -> HqpProblem:
    """Return (1 - alpha) chi_old + alpha chi_S: the old stack is solved beside the new one.

    Both are targets without acceleration limits, T(35); their mean is followed within the bounds of
    the command. In between it is no optimum; if pre-empted, it starts from the old stack again.
    """
    old = view.context.solve(HqpProblem(view.old(), view.context.free_bounds()))
    mean = (1.0 - alpha) * old + alpha * view.source
    return HqpProblem((view.group.follow(mean),), view.context.bounds)
