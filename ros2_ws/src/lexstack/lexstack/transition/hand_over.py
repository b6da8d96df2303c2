"""What a blend that is given up before its end hands over to the next one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lexstack.transition.blend import Blend
from lexstack.transition.gap_motion import GapMotion
from lexstack.transition.profiles import alpha
from lexstack.transition.tick_context import TickContext
from lexstack.types import Vector


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
