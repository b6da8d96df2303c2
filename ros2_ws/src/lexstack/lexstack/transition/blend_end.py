"""How a blend ends: given up for the next one, or in one more, to the controller's own optimum."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from lexstack.transition.blend import Blend
from lexstack.transition.bridge import Bridge
from lexstack.transition.gap_motion import GapMotion
from lexstack.transition.messages import Source
from lexstack.transition.profiles import alpha
from lexstack.transition.tick_context import TickContext
from lexstack.types import Vector

# Of the acceleration and the jerk limits: what fading the gap to the own optimum may add.
_LITTLE = (0.007, 0.002)
_SHORTEST = 0.1  # s
_SAME = 1e-3  # of what a joint's acceleration limit allows in one tick: no difference that is felt


def left_by(
    blend: Blend, tick: int, duration: float, context: TickContext
) -> tuple[Vector, GapMotion | None]:
    """Return what a blend, given up at ``tick``, leaves to the next one of ``duration`` [s].

    In a blend the command follows chi(t) = chi_S(t) + d(t), with the source's optimum chi_S and
    the gap d(t) = (1 - alpha) delta + what ``gap_motion`` adds. The next blend begins with the step
    that this would have made now, so that the velocity goes on as it was, and with the rate and
    the second derivative of d, so that the gap's part of the acceleration does. The source's
    part is known one tick later (``with_mismatch``).

    Returns:
        How far the command would have moved since the tick before, shape (n,), and the motion
        of the gap, None where it has none to keep.
    """
    if tick == blend.start:  # given up before it began: there is no tick before to compare with
        return blend.step, None if blend.gap_motion is None else replace(
            blend.gap_motion, duration=duration
        )
    # The source's part of the step. Its chi of this tick may be the very jump that ends this
    # blend, so it is taken to move as it did in the tick before.
    step = np.zeros_like(blend.step) if blend.drift is None else blend.drift
    gap_motion = None
    # Without a d(t) that is known ahead nothing is kept: the next blend begins from rest.
    if blend.timed is not None:
        times = tuple((tick + k - blend.start) * context.dt for k in (-1, 0, 1))
        # The gap's part of the step, with all that is in the gap.
        step = step + _gap(blend, times[1]) - _gap(blend, times[0])
        # d' and d'' by central differences over one tick to either side,
        #     d' = (d(t + dt) - d(t - dt)) / (2 dt)
        #     d'' = (d(t + dt) - 2 d(t) + d(t - dt)) / dt^2,
        # without the slips. These go on to fade beside the new gap, in their own short time
        # (``older``): in d'' their curvature would be led to rest in the whole duration, and
        # drive the command far off, farther with every latch.
        before, now, after = (_gap(blend, time, slips=False) for time in times)
        speed, bend = (after - before) / (2.0 * context.dt), (after - 2.0 * now + before)
        older = () if blend.gap_motion is None else blend.gap_motion.fading(times[1])
        gap_motion = GapMotion(speed, bend / context.dt**2, duration, older=older)
    # A step beyond the acceleration limit is no motion that the command could have made.
    reach = context.limits.acceleration * context.dt
    return np.minimum(np.maximum(step, -reach), reach), gap_motion


def _gap(blend: Blend, elapsed: float, *, slips: bool = True) -> Vector:
    """Return the gap after ``elapsed`` seconds, shape (n,), with the slips or without them."""
    gap = (1.0 - alpha(blend.request.profile, elapsed, blend.duration)) * blend.bridge.delta
    if blend.gap_motion is None:
        return gap
    moved = blend.gap_motion.at if slips else blend.gap_motion.lasting
    return gap + moved(max(elapsed, 0.0))


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
        f"the solver's chi at tick {tick} is {apart.max():.2g} (m/s, rad/s) off "
        "the controller's own: the controller blends on to its own"
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
