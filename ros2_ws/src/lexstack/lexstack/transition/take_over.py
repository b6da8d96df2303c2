"""The end of a blend whose source is not at the own optimum: one more blend, from it to that."""

from __future__ import annotations

import math

import numpy as np

from lexstack.transition.blend import Blend
from lexstack.transition.bridge import Bridge
from lexstack.transition.messages import Source
from lexstack.transition.tick_context import TickContext
from lexstack.types import Vector

# Of the acceleration and the jerk limits: what fading the gap to the own optimum may add.
_LITTLE = (0.007, 0.002)
_SHORTEST = 0.1  # s
_SAME = 1e-3  # of what a joint's acceleration limit allows in one tick: no difference that is felt


def at_end(blend: Blend, own: Vector, tick: int, context: TickContext) -> tuple[Blend, str]:
    """Return the blend at its end, and why it changes: if the own optimum is not the solver's.

    Args:
        blend: whose alpha is 1.
        own: the controller's own optimum of this tick, shape (n,).
        tick: this one.
        context: of this tick.
    """
    mine = blend.route.group.columns
    apart = np.abs(own - blend.source_chi)[mine]
    if (apart <= _SAME * context.limits.acceleration[mine] * context.dt).all():
        return blend, ""
    why = (
        f"robot B's chi at tick {tick} is {apart.max():.2g} (m/s, rad/s) off robot A's own: "
        "robot A blends on to its own"
    )
    return _taken_over(blend, own, tick, context), why


def _taken_over(blend: Blend, own: Vector, tick: int, context: TickContext) -> Blend:
    """Return the blend from the solver's chi of this tick to the own optimum, shape (n,).

    If the solver's chi is late or frozen, adopting the stack at once would make the command
    jump by their difference. It fades so slowly that it adds little acceleration and jerk
    (``_LITTLE``), and at most in the time of the blend before: a chi that is one tick old takes
    the shortest time. A later latch, as for a new target, has the request's whole time again.
    """
    gap = blend.source_chi - own
    step = np.zeros_like(own) if blend.drift is None else blend.drift
    return Blend(
        blend.route,
        Source.LOCAL,
        tick,
        _unfelt(blend, gap, context),
        Bridge(gap, None),
        own,
        step,
        alone=True,
        tally=blend.tally,
    )


def _unfelt(blend: Blend, gap: Vector, context: TickContext) -> float:
    """Return in which time [s] a gap (n,) fades with ``_LITTLE`` acceleration and jerk.

    The quintic's first and second derivative are at most 1.875 / T and 5.774 / T^2.
    """
    mine, limits = blend.route.group.columns, context.limits
    size = np.abs(gap[mine])
    by_rate = 1.875 * float((size / limits.acceleration[mine]).max()) / _LITTLE[0]
    by_jerk = math.sqrt(5.774 * float((size / limits.jerk[mine]).max()) / _LITTLE[1])
    return min(blend.duration, max(_SHORTEST, by_rate, by_jerk))
