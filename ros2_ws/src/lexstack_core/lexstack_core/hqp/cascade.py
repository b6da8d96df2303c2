"""Strict priorities: exchange on the whole hierarchy first, then one level after the other.

Each level of the cascade is solved in the null space of those above, T(8) to T(15) with the
equalities T(11), T(15) eliminated: chi = chi_k + N z. The bounds of chi and the inequality rows of
the levels above become two-sided rows of z, clamped so that z = 0 stays feasible whatever rounding
has done. Every level below therefore only moves where no level above notices.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lexstack_core.hqp.exchange import solve_by_exchange
from lexstack_core.hqp.factor import factorise
from lexstack_core.hqp.problem import HqpProblem, Solution, Status
from lexstack_core.hqp.qp import LevelQp, QpBackend, level_qp
from lexstack_core.hqp.refine import Point, refine
from lexstack_core.hqp.rows import FEASIBILITY, LevelRows, Signs
from lexstack_core.linear import LinearTask, Matrix, Vector

EXCHANGES = 6  # guesses of the whole working set before the cascade decides
_NEGLIGIBLE = 1e-9  # rows of a reduced bound shorter than this cannot leave it


@dataclass(frozen=True, slots=True)
class _Walls:
    """Rows that no level below may leave: the bounds of chi, satisfied inequality rows.

    Attributes:
        matrix: shape (h, n).
        lower: shape (h,).
        upper: shape (h,).
        tolerance: reduced rows shorter than this cannot be left.
    """

    matrix: Matrix
    lower: Vector
    upper: Vector
    tolerance: float


class NullSpaceCascade:
    """The strict solver around a backend for quadratic programs."""

    def __init__(self, backend: QpBackend, exchanges: int = EXCHANGES) -> None:
        """Use a backend; ``exchanges`` guesses are tried first, 0 leaves all to the backend."""
        self.name = f"{backend.name}_cascade"
        self._backend = backend
        self._exchanges = exchanges

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve all levels in order.

        Freedom that no level uses is spent on the smallest ``||chi||``. ``warm`` speeds the solve
        up by its active set and has no other influence than rounding.

        Raises:
            InputError: a task does not fit chi (a programming error, not a state of the robot).
        """
        start = time.perf_counter()
        lower, upper = problem.bounds.lower, problem.bounds.upper
        n = lower.size
        levels = [LevelRows(tasks, n) for tasks in problem.levels]
        rest = np.minimum(np.maximum(lower, 0.0), upper)
        reason = _unusable(levels, lower, upper, rest)
        if reason:
            return _failed(levels, _inside(lower, upper), reason, start)
        held: Signs = np.zeros(n, dtype=np.int8)
        if warm is not None and warm.active.size == n:
            held = warm.active
        chi = solve_by_exchange(levels, lower, upper, held, self._exchanges)
        if chi is None:
            chi, reason = self._descend(levels, lower, upper, rest, held)
        chi = np.minimum(np.maximum(chi, lower), upper)
        return _solution(levels, lower, upper, chi, reason, start)

    def _descend(
        self, levels: list[LevelRows], lower: Vector, upper: Vector, chi: Vector, held: Signs
    ) -> tuple[Vector, str]:
        """Solve level by level from a chi inside the bounds; return chi and why it stopped."""
        basis: Matrix = np.eye(lower.size)[:, upper - lower > FEASIBILITY]
        walls = [_Walls(np.eye(lower.size), lower, upper, _NEGLIGIBLE)]
        for k, level in enumerate([*levels, _smallest(lower.size)]):
            if basis.shape[1] == 0:
                break
            qp, joints = _reduce(level, chi, basis, walls)
            point = self._solve_level(qp, held[joints])
            if isinstance(point, str):
                return chi, f"level {k}: {self._backend.name}: {point}"
            chi = np.minimum(np.maximum(chi + basis.dot(point.z), lower), upper)
            basis = basis.dot(point.null)
            if not level.exact:
                walls.append(_satisfied(level, point.broken))
        return chi, ""

    def _solve_level(self, qp: LevelQp, guess: Signs) -> Point | str:
        """Return the optimum of a level, or the backend's word for why there is none."""
        factor = factorise(qp.objective, qp.tolerance)
        x = factor.solve(qp.target)
        if _contains(qp, x):
            r = x.size - qp.slacks
            return Point(x[:r], factor.null[:r], np.zeros(qp.slacks, dtype=np.bool_))
        if factor.rank < min(qp.objective.shape):
            # What counts as zero is made zero, so that the backend and the levels below agree.
            rounding = qp.objective.dot(factor.null).dot(factor.null.T)
            qp = replace(qp, objective=qp.objective - rounding)
        answer = self._backend.solve(qp, guess)
        return answer.reason or refine(qp, answer)


def _reduce(
    level: LevelRows, chi: Vector, basis: Matrix, walls: list[_Walls]
) -> tuple[LevelQp, NDArray[np.intp]]:
    """Return a level in z with chi + N z, and the joints that its first hard rows belong to."""
    hard, below, above = [], [], []
    joints = np.empty(0, dtype=np.intp)
    for k, wall in enumerate(walls):
        rows = basis if k == 0 else wall.matrix.dot(basis)
        # Rows that the levels above have used up hold rounding errors, on which solvers fail.
        felt = np.flatnonzero(np.einsum("ij,ij->i", rows, rows) > wall.tolerance * wall.tolerance)
        value = wall.matrix.dot(chi)
        hard.append(rows[felt])
        below.append((wall.lower - value)[felt])
        above.append((wall.upper - value)[felt])
        joints = felt if k == 0 else joints
    reduced = level.matrix.dot(basis)
    reduced[np.einsum("ij,ij->i", reduced, reduced) <= level.tolerance * level.tolerance] = 0.0
    value = level.matrix.dot(chi)
    qp = level_qp(
        reduced,
        level.equal,
        (level.lower - value, level.upper - value),
        (
            np.concatenate(hard),
            np.minimum(np.concatenate(below), 0.0),
            np.maximum(np.concatenate(above), 0.0),
        ),
        level.norm,
        level.tolerance,
    )
    return qp, joints


def _satisfied(level: LevelRows, broken: NDArray[np.bool_]) -> _Walls:
    """Return a level's satisfied inequality rows as constraints of the levels below.

    The broken ones are equations for them, and part of the null space already.
    """
    rows = np.flatnonzero(~level.equal)[~broken]
    return _Walls(level.matrix[rows], level.lower[rows], level.upper[rows], level.tolerance)


def _contains(qp: LevelQp, x: Vector) -> bool:
    """Whether x is inside all rows, up to rounding."""
    value = qp.rows.dot(x)
    excess = np.maximum(value - qp.upper, qp.lower - value)
    return bool(excess.max(initial=0.0) <= FEASIBILITY)


def _smallest(n: int) -> LevelRows:
    """Return the level below all others: the smallest ``||chi||`` of what is still free."""
    return LevelRows((LinearTask.equality("smallest", np.eye(n), np.zeros(n)),), n)


def _unusable(levels: list[LevelRows], lower: Vector, upper: Vector, rest: Vector) -> str:
    """Return why a problem cannot be solved at all: empty or not finite; else an empty string."""
    if not (lower <= upper).all() or not math.isfinite(rest.dot(rest)):
        joint = int(np.argmin((lower <= upper) & np.isfinite(rest)))
        return f"bounds: joint {joint}: [{lower[joint]}, {upper[joint]}] is empty"
    for k, level in enumerate(levels):
        if not math.isfinite(level.slack(rest)):
            return f"level {k}: a task holds a number that is not finite"
        if not level.exact and not (level.lower <= level.upper).all():
            return f"level {k}: a task has a row with lower above upper"
    return ""


def _inside(lower: Vector, upper: Vector) -> Vector:
    """Return the point of the bounds next to zero, and zero where the bounds are unusable."""
    with np.errstate(invalid="ignore"):
        chi = np.minimum(np.maximum(lower, 0.0), upper)
    return np.where((lower <= upper) & np.isfinite(chi), chi, 0.0)


def _failed(levels: list[LevelRows], chi: Vector, reason: str, start: float) -> Solution:
    """Return a failure before any level was solved."""
    return _solution(levels, chi, chi, chi, reason, start)


def _solution(
    levels: list[LevelRows], lower: Vector, upper: Vector, chi: Vector, reason: str, start: float
) -> Solution:
    """Return chi with its residuals and the bounds that it touches."""
    active = (chi >= upper).astype(np.int8)
    active[(chi <= lower) & (active == 0)] = -1
    slacks = np.array([level.slack(chi) for level in levels])
    for array in (chi, active, slacks):
        array.setflags(write=False)
    status = Status.FAILED if reason else Status.SOLVED
    return Solution(chi, slacks, status, reason, active, time.perf_counter() - start)
