"""What A solves at one tick, on the way from stack to stack or on its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from lexstack_core.bounds import Bounds, JointLimits
from lexstack_core.hqp import HqpProblem
from lexstack_core.linear import Vector


@dataclass(frozen=True, slots=True)
class Plan:
    """What A solves at one tick.

    Attributes:
        problem: levels and box.
        source: the chi that A goes to, shape (n,), or None when it serves its own stack.
        alpha: of the blend, 1 when there is none.
    """

    problem: HqpProblem
    source: Vector | None
    alpha: float


@dataclass(frozen=True, slots=True)
class Means:
    """What the controller lends to a transition for one tick.

    Attributes:
        bounds: A's own box.
        before: A's box of the tick before; that of this tick where there is none.
        free: the box without acceleration limits, T(35).
        solve: solves a further problem; its chi has shape (n,).
        limits: of the joints.
        dt: control period [s].
    """

    bounds: Bounds
    before: Bounds
    free: Callable[[], Bounds]
    solve: Callable[[HqpProblem], Vector]
    limits: JointLimits
    dt: float

    @property
    def reach(self) -> Vector:
        """How far each joint's velocity may change in one tick, shape (n,), m/s and rad/s."""
        return 0.5 * (self.bounds.upper - self.bounds.lower)
