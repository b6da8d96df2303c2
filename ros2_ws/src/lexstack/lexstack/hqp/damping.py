"""Damping of levels near singularities, applied to a problem just before it is solved."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from lexstack.compiled import kernel
from lexstack.hqp.group_level import GroupLevel
from lexstack.hqp.groups import Group
from lexstack.hqp.hierarchy import Mask, Signs
from lexstack.hqp.irregular import Margins
from lexstack.hqp.lift import TOLD, Above, lift, pressed
from lexstack.hqp.problem import HqpProblem, NearSingular, Solution
from lexstack.limits.joint_limits import JointLimits
from lexstack.robots import Kinematics, Team
from lexstack.types import LinearTask, Vector

_AT_LIMIT = 0.03  # of the velocity limit: slower towards its position limit, a joint stands there
_ERRORS = (ArithmeticError, ValueError)  # numpy's LinAlgError is a ValueError


@dataclass(frozen=True, slots=True)
class Damped:
    """A problem as it is solved.

    Attributes:
        given: as it was asked for.
        problem: with the rows that were added; the very same one where there are none.
        near: the levels near a singularity, with and without added rows.
        failure: why none could be found, else empty: then the problem is solved as it was given.
    """

    given: HqpProblem
    problem: HqpProblem
    near: tuple[NearSingular, ...] = ()
    failure: str = ""

    def warm(self, last: Solution | None) -> Solution | None:
        """Return the solution of the tick before, whose rows are those of the given problem."""
        if self.problem is self.given or last is None or not last.rows.size:
            return last
        mask = self._own()
        if last.rows.size != np.count_nonzero(mask):
            return last
        rows: Signs = np.zeros(mask.size, dtype=np.int8)
        rows[mask] = last.rows
        return replace(last, rows=rows)

    def own(self, solution: Solution) -> Solution:
        """Return the solution with slacks and rows of the given problem's own rows alone.

        Args:
            solution: of ``problem``, chi of shape (n,).
        """
        if self.failure:
            return replace(solution, undamped=self.failure)
        if self.problem is self.given:
            return replace(solution, near=self.near) if self.near else solution
        residuals = [
            np.concatenate([task.residual(solution.chi) for task in level])
            for level in self.given.levels
        ]
        slacks = np.array([np.sqrt(r.dot(r)) for r in residuals])
        rows = solution.rows[self._own()] if solution.rows.size else solution.rows
        for array in (slacks, rows):
            array.setflags(write=False)
        return replace(solution, slacks=slacks, rows=rows, near=self.near)

    def _own(self) -> Mask:
        """Return which rows of ``problem`` are those of the given one."""
        mask = [
            np.full(task.lower.size, place < len(given), dtype=np.bool_)
            for given, level in zip(self.given.levels, self.problem.levels, strict=True)
            for place, task in enumerate(level)
        ]
        return np.concatenate(mask)


class Damper:
    """Adds rows to levels that are near a singularity; they depend on the present tick alone."""

    def __init__(self, team: Team, dt: float) -> None:
        """Know whose joints are where; ``dt`` is the control period [s]."""
        self._slices = team.slices
        self._positions = team.joint_positions
        self._margins = Margins(team.slices)
        self._dt = dt

    def damped(
        self,
        problem: HqpProblem,
        kinematics: Kinematics,
        limits: JointLimits,
    ) -> Damped:
        """Return a problem with the rows of ``lift``; the same one where all levels are regular.

        It never raises for numbers that are none: then the problem stays as it is.

        Args:
            problem: about to be solved, over all joints of the team.
            kinematics: of this tick.
            limits: of the joints, in force.
        """
        sides = _sides(self._positions(kinematics.state.q_star), limits, self._dt)
        irregular = self._margins.irregular(problem, sides, kinematics)
        if not irregular:
            return Damped(problem, problem)
        sides = np.zeros(self._slices[-1].stop) if sides is None else sides
        try:
            # What is no number ends in a factorisation that says so; numpy need not warn as well.
            with np.errstate(all="ignore"):
                levels = [list(level) for level in problem.levels]
                near: list[NearSingular] = []
                for group, mine, regular in irregular:
                    above = Above.of_held(pressed(mine, sides[group.columns]))
                    for level in mine[:regular]:
                        above.take(level)
                    near += self._lift((group, mine, regular), above, kinematics, levels)
        except _ERRORS as error:
            return Damped(problem, problem, failure=f"no damping near singularities: {error}")
        near.sort(key=lambda entry: entry.level)
        if not any(entry.rows for entry in near):
            return Damped(problem, problem, tuple(near))
        extended = tuple([tuple(level) for level in levels])
        return Damped(problem, HqpProblem(extended, problem.bounds), tuple(near))

    def _lift(
        self,
        share: tuple[Group, list[GroupLevel], int],
        above: Above,
        kinematics: Kinematics,
        levels: list[list[LinearTask]],
    ) -> list[NearSingular]:
        """Change ``levels`` as far as they concern one group; return which are near singular.

        Args:
            share: the group, its share of each level, and how many of these are regular.
            above: what the regular ones leave.
            kinematics: of this tick.
            levels: of the problem.
        """
        near = []
        group, mine, regular = share
        triples = list(zip(group.ranks, group.tasks, mine, strict=True))
        for k, places, level in triples[regular:]:
            rows, more, target, least = lift(level, above, kinematics, group.places)
            names = " + ".join([task.name for task in level.tasks])
            if len(rows) or least < TOLD:
                near.append(NearSingular(k, names, least, len(rows)))
            if not len(rows):
                continue
            if not math.isfinite(float(np.square(rows).sum()) + float(more.dot(more))):
                raise FloatingPointError("a row is not finite")
            if more.any():
                for place, start in zip(places, level.starts, strict=True):
                    levels[k][place] = _moved(levels[k][place], more[start:])
            matrix = np.zeros((len(rows), self._slices[-1].stop))
            matrix[:, group.columns] = rows
            curve = next(task.curve for task in level.tasks if task.curve is not None)
            added = LinearTask.equality(f"{names}: damping", matrix, curve.gain * target, curve)
            levels[k].append(added)
        return near


def _moved(task: LinearTask, more: Vector) -> LinearTask:
    """Return a task that asks to remove ``more`` of its error as well, shape (at least m,)."""
    if task.curve is None:
        return task
    target = task.lower + task.curve.gain * more[: task.lower.size]
    return LinearTask(task.name, task.matrix, target, target, task.curve, task.feed, task.frame)


def _sides(position: Vector, limits: JointLimits, dt: float) -> Vector | None:
    """Return +1 or -1 where a joint stands at its upper or lower position limit, shape (n,).

    None: no joint does.
    """
    upper, lower = _margins(limits, dt)
    fast = kernel("lexstack.hqp.kernel.margins")
    if fast is not None and not fast.stands(position, upper, lower):
        return None
    above, below = position > upper, position < lower
    if not (np.count_nonzero(above) or np.count_nonzero(below)):
        return None
    sides: Vector = above.astype(float)
    sides -= below
    return sides


@lru_cache(maxsize=64)
def _margins(limits: JointLimits, dt: float) -> tuple[Vector, Vector]:
    """Return beyond which positions a joint stands at its upper and at its lower limit, (n,) each.

    From there on it may move towards the limit with less than a small part of its velocity limit:
    ``approach_speed`` solved for the room.
    """
    speed, step = _AT_LIMIT * limits.velocity, limits.acceleration * dt
    room = ((speed + step) ** 2 - step**2) / (2.0 * limits.acceleration)
    return limits.position_upper - room, limits.position_lower + room
