"""The motion of robots at the tick of a latch: how they would go on without it."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.transition.gap_motion import GapMotion
from lexstack.types import Vector

HURRY = 0.0999  # s: of three latches, each within 0.1 s of the next, the last takes up no mismatch


@dataclass(frozen=True, slots=True, eq=False)
class LatchState:
    """How some robots would go on without the latch.

    Attributes:
        start: chi_A, the command that would be sent at this tick, shape (n,).
        level_goes_on: whether level 1 has the same rows and targets as before.
        gap_motion: the motion of the gap that was fading, None where there was none.
        recent: how many latches came before this one, each within ``HURRY`` of the next.
    """

    start: Vector
    level_goes_on: bool
    gap_motion: GapMotion | None
    recent: int = 0
