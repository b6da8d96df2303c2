"""What robots did until a tick at which A latches: where they would go on without it."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.transition.gap_motion import GapMotion
from lexstack.types import Vector

HURRY = 0.0999  # s: of three latches within 0.1 s each, the last takes up no acceleration


@dataclass(frozen=True, slots=True, eq=False)
class LatchState:
    """What A was about to do with some robots.

    Attributes:
        start: chi_A, what A would send at this tick, shape (n,).
        level_goes_on: whether level 1 asks for what it asked for before.
        carry: the motion of the gap that was fading, None where there was none.
        recent: how many latches came before this one, each within ``HURRY`` of the next.
    """

    start: Vector
    level_goes_on: bool
    carry: GapMotion | None
    recent: int = 0
