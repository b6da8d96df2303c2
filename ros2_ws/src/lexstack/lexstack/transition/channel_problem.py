"""What the controller solves at one tick, during a transition or on a stack of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lexstack.hqp import HqpProblem
from lexstack.limits.joint_limits import Bounds
from lexstack.transition.robot_group import Columns
from lexstack.types import Vector


@dataclass(frozen=True, slots=True)
class Plan:
    """What the controller solves at one tick for the robots of one channel.

    Attributes:
        problem: levels and box.
        source: the chi that the command goes to, shape (n,), or None without a transition.
        alpha: of the blend, 1 when there is none.
    """

    problem: HqpProblem
    source: Vector | None
    alpha: float


@dataclass(frozen=True, slots=True)
class Plans:
    """What the controller solves at one tick.

    Attributes:
        problem: of all robots.
        each: of every channel, in their order.
    """

    problem: HqpProblem
    each: tuple[Plan, ...]

    @classmethod
    def of(cls, plans: Sequence[Plan], columns: Sequence[Columns]) -> Plans:
        """Return the plans of channels that share no robot as one problem.

        Levels of equal rank stand side by side: no row of one plan has joints of another, so the
        optimum of the whole is that of each.

        Args:
            plans: one per channel.
            columns: of each channel's joints.
        """
        if len(plans) == 1:
            return cls(plans[0].problem, tuple(plans))
        problems = [plan.problem for plan in plans]
        depth = max(len(problem.levels) for problem in problems)
        levels = tuple(
            tuple(task for p in problems if k < len(p.levels) for task in p.levels[k])
            for k in range(depth)
        )
        box = problems[0].bounds
        if any(problem.bounds is not box for problem in problems):
            lower, upper = box.lower.copy(), box.upper.copy()
            for problem, mine in zip(problems, columns, strict=True):
                lower[mine] = problem.bounds.lower[mine]
                upper[mine] = problem.bounds.upper[mine]
            box = Bounds(lower, upper)
        return cls(HqpProblem(tuple(level for level in levels if level), box), tuple(plans))
