"""What a transition needs of one tick, in one record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from lexstack.hqp import HqpProblem
from lexstack.limits import Bounds, JointLimits
from lexstack.references import References
from lexstack.robots import Kinematics
from lexstack.types import Vector


@dataclass(frozen=True, slots=True)
class TickContext:
    """One tick of the controller, as its transitions see it.

    Attributes:
        kinematics: at the measured state.
        references: in effect at this tick.
        references_before: in effect at the tick before.
        bounds: of the command, with the acceleration limits.
        bounds_before: those of the tick before; of this tick where there is none.
        free_bounds: returns the bounds without acceleration limits, T(35).
        solve: solves a further problem; its chi has shape (n,). Where that fails, ``held``.
        limits: of the joints.
        dt: control period [s].
        held: returns the command in force, within the bounds, shape (n,); it is used in place of a
            solution that failed, for the reason given, which is reported.
    """

    kinematics: Kinematics
    references: References
    references_before: References
    bounds: Bounds
    bounds_before: Bounds
    free_bounds: Callable[[], Bounds]
    solve: Callable[[HqpProblem], Vector]
    limits: JointLimits
    dt: float
    held: Callable[[str], Vector]

    @property
    def tick(self) -> int:
        """The tick's number."""
        return self.kinematics.state.tick

    @property
    def anew(self) -> bool:
        """Whether targets took effect at this tick; a set-point that is led in is none."""
        now, before = self.references, self.references_before
        return now is not before and (now.revision != before.revision or not now.revision)

    @property
    def reach(self) -> Vector:
        """How far each joint's velocity may change in one tick, shape (n,), m/s and rad/s."""
        return 0.5 * (self.bounds.upper - self.bounds.lower)

    def between(self, before: References, now: References) -> TickContext:
        """Return this tick for robots whose references were ``before`` and are ``now``."""
        if now is self.references and before is self.references_before:
            return self
        return replace(self, references=now, references_before=before)
