"""No transition at all: what today's libraries do."""

from __future__ import annotations

from lexstack.hqp import HqpProblem
from lexstack.transition import Bridge, View


def instant(view: View, _latched: Bridge, _alpha: float) -> HqpProblem:
    """Return the source's optimum as it is, without acceleration limits."""
    return HqpProblem((view.group.follow(view.source),), view.context.free_bounds())


def instant_limited(view: View, _latched: Bridge, _alpha: float) -> HqpProblem:
    """Return the new stack within the command's box: the strong baseline, smooth by limits."""
    return HqpProblem(view.new(), view.context.bounds)
