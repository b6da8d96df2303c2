"""The bridge: see lexstack.transition.bridge for what it does and why."""

from __future__ import annotations

from lexstack.hqp import HqpProblem
from lexstack.transition.bridge import Bridge, bridged
from lexstack.transition.methods.view import View, below


def bridge(view: View, latched: Bridge, alpha: float) -> HqpProblem:
    """Return level 1 and below it the source's chi, both with their latched gap fading out."""
    first, target = bridged(latched, view.first, view.source, alpha)
    return HqpProblem(below(first, view.group.follow(target)), view.context.bounds)
