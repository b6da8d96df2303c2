"""What a transition method sees of one tick, and what a method is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from lexstack.hqp import HqpProblem
from lexstack.transition.bridge import Bridge
from lexstack.transition.robot_group import RobotGroup
from lexstack.transition.tick_context import TickContext
from lexstack.types import LinearTask, Vector

Levels = tuple[tuple[LinearTask, ...], ...]
"""The tasks of each level, the highest first."""


@dataclass(frozen=True, slots=True)
class View:
    """One tick of a blend. What only some methods need is a function, called by those alone.

    Attributes:
        group: the robots that switch; all levels below are theirs.
        first: level 1 of the new stack.
        source: chi_S, the source's optimum of the new stack, shape (n,).
        new: all levels of the new stack.
        old: all levels of the stack that the robots come from.
        context: of this tick.
    """

    group: RobotGroup
    first: tuple[LinearTask, ...]
    source: Vector
    new: Callable[[], Levels]
    old: Callable[[], Levels]
    context: TickContext


# (this tick, what was latched at the trigger, alpha in [0, 1]) -> what the controller solves
Method = Callable[[View, Bridge, float], HqpProblem]
"""A transition method. At alpha = 1 its problem's optimum is the source's, within the bounds."""


def below(first: tuple[LinearTask, ...], second: tuple[LinearTask, ...]) -> Levels:
    """Return two levels; on a plan there is no first one."""
    return (first, second) if first else (second,)
