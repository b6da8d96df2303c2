"""What robots did until a tick at which A latches: where they would go on without it."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack_core.linear import Vector
from lexstack_core.transition.carry import Carry


@dataclass(frozen=True, slots=True, eq=False)
class Past:
    """What A was about to do with some robots.

    Attributes:
        start: chi_A, what A would send at this tick, shape (n,).
        level_goes_on: whether level 1 asks for what it asked for before.
        carry: the motion of the gap that was fading, None where there was none.
        calm: whether a latch before this one is long ago, so that the command's motion is no
            more a matter of latching.
    """

    start: Vector
    level_goes_on: bool
    carry: Carry | None
    calm: bool = True
