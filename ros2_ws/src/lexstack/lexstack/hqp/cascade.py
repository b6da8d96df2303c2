"""Strict priorities: the active set of the whole hierarchy first, then one level after the other.

Each level of the cascade is solved in the null space of those above, T(8) to T(15) with the
equalities T(11), T(15) eliminated: chi = chi_k + N z. The bounds of chi and the inequality rows of
the levels above become two-sided rows of z, clamped so that z = 0 stays feasible whatever rounding
has done. Every level below therefore only moves where no level above notices.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from lexstack.hqp.active_set import WorkingSet, solve_by_active_set
from lexstack.hqp.columns import column_powers, restored_columns, scaled_columns, warm_columns
from lexstack.hqp.hierarchy import FEASIBILITY, Hierarchy, LevelRows, Signs
from lexstack.hqp.level_qp import LevelQp, QpBackend
from lexstack.hqp.nullspace_level import InheritedConstraints, reduce_level
from lexstack.hqp.preconditions import active_bounds, starting_point
from lexstack.hqp.problem import HqpProblem, Solution, Status, called
from lexstack.hqp.rank_revealing_qr import factorise
from lexstack.hqp.refine import Point, refine
from lexstack.hqp.scaling import Bands, scaled
from lexstack.hqp.unmet import with_weights
from lexstack.types import LinearTask, Matrix, Vector

_BACKEND_ERRORS = (ArithmeticError, RuntimeError, ValueError)
_ROUNDS = 3  # guesses in a row, each a correction of the one before
_FEW = 2  # wrong places in the last active set: with more of them the backend foresees better


class NullSpaceCascade:
    """The strict solver around a backend for quadratic programs."""

    def __init__(self, backend: QpBackend, guesses: bool = True) -> None:
        """Use a backend; without ``guesses`` every level goes through it."""
        self.name = f"{backend.name}_cascade"
        self._backend = backend
        self._guesses = guesses

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve all levels in order.

        Freedom that no level uses is spent on the smallest ``||chi||``. ``warm`` speeds the solve
        up by its active set and has no other influence than rounding.

        Raises:
            InputError: a task does not fit chi (a programming error, not a state of the robot).
        """
        start = time.perf_counter()
        # Numbers that are not finite are found and said; numpy need not warn of them as well.
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            hierarchy = Hierarchy(problem.levels, problem.bounds.lower.size)
            powers = column_powers(hierarchy, problem)
            if powers is None:
                return self._solved(problem, hierarchy, warm, start)
            other = scaled_columns(problem, powers)
            warm = warm_columns(warm, powers.size)
            found = self._solved(other, Hierarchy(other.levels, powers.size), warm, start)
            return restored_columns(found, powers, hierarchy, problem.bounds)

    def _solved(
        self, problem: HqpProblem, hierarchy: Hierarchy, warm: Solution | None, start: float
    ) -> Solution:
        """Solve a problem whose columns are of about one size; ``start`` is when it was asked."""
        chi, reason = starting_point(hierarchy, problem)
        even, bands = hierarchy, None
        if not reason:
            even, bands = scaled(hierarchy, problem.levels)
            working_set = _last(hierarchy, warm, chi.size)
            if bands is not None:
                working_set.rows = bands.rows_of(working_set.rows)
            held = warm.active if warm is not None and warm.active.size == chi.size else None
            chi, reason = self._chi(even, bands, problem, chi, working_set, held)
        slacks = hierarchy.slacks(hierarchy.residual(chi))
        rows = even.active_bounds(chi)
        if bands is not None:
            rows = bands.restored(rows)
        active = active_bounds(chi, problem.bounds)
        for array in (chi, active, slacks, rows):
            array.setflags(write=False)
        status = Status.FAILED if reason else Status.SOLVED
        return Solution(chi, slacks, status, reason, active, time.perf_counter() - start, rows)

    def _chi(
        self,
        hierarchy: Hierarchy,
        bands: Bands | None,
        problem: HqpProblem,
        chi: Vector,
        working_set: WorkingSet,
        held: Signs | None,
    ) -> tuple[Vector, str]:
        """Return chi inside the bounds, and why it is not the optimum, if it is not.

        Args:
            hierarchy: scaled.
            bands: how, if it was.
            problem: as given, with the bounds of chi.
            chi: a point inside them, shape (n,).
            working_set: what probably holds.
            held: the joints that held at the last optimum, if there is one, shape (n,).
        """
        lower, upper = problem.bounds.lower, problem.bounds.upper
        if not chi.size:
            return chi, ""
        if self._guesses:
            guessed = self._guess(hierarchy, lower, upper, working_set, bands)
            if guessed is not None:
                return np.minimum(np.maximum(guessed, lower), upper), ""
        chi, k, why = self._descend(
            hierarchy.levels, lower, upper, chi, working_set.joints if held is None else held
        )
        if why:
            level = k if bands is None else bands.owner[k]
            return chi, f"{called(level, problem.levels[level])}: {self._backend.name}: {why}"
        if bands is None or not bands.several:
            return chi, ""
        chi, unmet = with_weights(hierarchy, bands, (lower, upper), chi)
        if unmet < 0:
            return chi, ""
        return chi, f"{called(unmet, problem.levels[unmet])}: its rows differ too much in size"

    def _guess(
        self,
        hierarchy: Hierarchy,
        lower: Vector,
        upper: Vector,
        working_set: WorkingSet,
        bands: Bands | None,
    ) -> Vector | None:
        """Return the optimum if the last active set, or one that the backend foresees, is its."""
        chi = solve_by_active_set(
            hierarchy, lower, upper, working_set, _ROUNDS, changes=_FEW, bands=bands
        )
        if chi is not None:
            return chi
        try:
            sides = self._backend.predict_active_set(hierarchy, lower, upper, working_set.joints)
        except _BACKEND_ERRORS:
            sides = None
        if sides is None:
            return None
        predicted = WorkingSet.split(hierarchy, sides)
        return solve_by_active_set(hierarchy, lower, upper, predicted, _ROUNDS, bands=bands)

    def _descend(
        self, levels: list[LevelRows], lower: Vector, upper: Vector, chi: Vector, held: Signs
    ) -> tuple[Vector, int, str]:
        """Solve level by level from a chi inside the bounds; return chi, where it ended and why."""
        basis: Matrix = np.eye(lower.size)[:, upper - lower > FEASIBILITY]
        inherited = [InheritedConstraints.of_bounds(lower, upper)]
        for k, level in enumerate([*levels, _smallest(lower.size)]):
            if basis.shape[1] == 0:
                break
            qp, joints = reduce_level(level, chi, basis, inherited)
            point = self._solve_level(qp, held[joints])
            if isinstance(point, str):
                # All levels are solved when only the smallest chi is not.
                return chi, k, "" if k == len(levels) else point
            chi = np.minimum(np.maximum(chi + basis.dot(point.z), lower), upper)
            basis = basis.dot(point.null)
            if not level.exact:
                inherited.append(InheritedConstraints.of_satisfied(level, point.broken))
        return chi, 0, ""

    def _solve_level(self, qp: LevelQp, guess: Signs) -> Point | str:
        """Return the optimum of a level, or the backend's word for why there is none."""
        factor = factorise(qp.objective, qp.tolerance)
        x = factor.solve(qp.target)
        if qp.contains(x):
            r = x.size - qp.slacks
            return Point(x[:r], factor.null[:r], np.zeros(qp.slacks, dtype=np.bool_))
        if factor.rank < min(qp.objective.shape):
            # What counts as zero is made zero, so that the backend and the levels below agree.
            rounding = qp.objective.dot(factor.null).dot(factor.null.T)
            qp = replace(qp, objective=qp.objective - rounding)
        try:
            sides = self._backend.solve(qp, guess)
        except _BACKEND_ERRORS as error:
            return str(error)
        return sides if isinstance(sides, str) else refine(qp, sides)


def _last(hierarchy: Hierarchy, warm: Solution | None, n: int) -> WorkingSet:
    """Return the active set of the solution before, as far as it fits; else nothing is held."""
    rows: Signs = np.zeros(hierarchy.lower.size, dtype=np.int8)
    if warm is None or warm.active.size != n:
        return WorkingSet(np.zeros(n, dtype=np.int8), rows)
    if not hierarchy.exact and warm.rows.size == rows.size:
        ends = np.where(warm.rows > 0, hierarchy.upper, hierarchy.lower)
        rows = np.where(hierarchy.equal | np.isinf(ends), np.int8(0), warm.rows)
    return WorkingSet(warm.active.copy(), rows)


def _smallest(n: int) -> LevelRows:
    """Return the level below all others: the smallest ``||chi||`` of what is still free."""
    return Hierarchy(((LinearTask.equality("smallest", np.eye(n), np.zeros(n)),),), n).levels[0]
