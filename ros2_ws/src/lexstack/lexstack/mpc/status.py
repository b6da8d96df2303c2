"""How each level ended: a value that cannot be mistaken for success."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Outcome(Enum):
    """What became of a level."""

    CONVERGED = "converged"  # its optimality conditions hold: there was nothing left to gain
    STEPPED = "stepped"  # it took at least one step, and the last QP was solved
    # No step was found: the line search refused all along the QP's direction, or the QP was called
    # infeasible, although the zero step is always allowed.
    BLOCKED = "blocked"
    FAILED = "failed"  # a QP was not solved, or something was not finite
    SKIPPED = "skipped"  # not tried, because a level above failed
    LATE = "late"  # not tried, because the solve's deadline would have passed

    @property
    def sound(self) -> bool:
        """Whether the levels below may be served: everything but FAILED and SKIPPED."""
        return self not in (Outcome.FAILED, Outcome.SKIPPED)


@dataclass(frozen=True, slots=True)
class LevelStatus:
    """One level of one solve.

    Attributes:
        level: its place, 0 the highest.
        name: of its task.
        outcome: see there; only CONVERGED and STEPPED are successes.
        iterations: of SQP that were begun.
        steps: alpha of each line search, in order; 0 where it found none.
        trials: of all line searches together.
        blocked_by: what refused the last trial that was refused: ``descent``, ``not finite``, or
            the level, state and row of the lexicographic constraint; empty if none was.
        qp: the QP solver's last word: ``solved``, or the reason why not.
        cost: J of H(8) at the end.
        decrease: by how much the whole cost fell, barriers and effort included, >= 0.
        late: whether the deadline of the solve ended it, before its first iteration or later.
        condensed: QPs that the kernel left to the condensed QP; 0 where that is asked for.
    """

    level: int
    name: str
    outcome: Outcome
    iterations: int
    steps: tuple[float, ...]
    trials: int
    blocked_by: str
    qp: str
    cost: float
    decrease: float
    late: bool = False
    condensed: int = 0

    @property
    def succeeded(self) -> bool:
        """Whether the level stepped or was at its optimum."""
        return self.outcome in (Outcome.CONVERGED, Outcome.STEPPED)

    @property
    def text(self) -> str:
        """One line for logs and status messages; levels are counted from 1 in it."""
        step = f"alpha {self.steps[-1]:.3g}" if self.steps else "no step"
        line = f"level {self.level + 1} {self.name}: {self.outcome.value}, {step}"
        if self.qp != "solved":
            line += f", QP {self.qp}"
        if self.late and self.outcome is not Outcome.LATE:
            line += ", ended by the deadline"
        return f"{line}, blocked by {self.blocked_by}" if self.blocked_by else line
