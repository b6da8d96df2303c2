"""What others would use for the same problem: cascades on their libraries, and DAQP's own mode.

A cascade as it is usually written: level k minimises ``||A_k chi - b_k||`` with the optimum of the
levels above as equality rows, T(11), the bounds as bounds, and the library's chi taken as it is.
An inequality row takes a slack. All libraries get the same care: double precision limits, a
proximal term where they need a definite H, no printing, no checks that cost time.

DAQP's hierarchical mode takes all levels in one call.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from time import perf_counter
from typing import Any

import daqp
import numpy as np
import quadprog
from proxsuite import proxqp

from lexstack.hqp import Hierarchy, HqpProblem, HqpSolver, Solution, Status
from lexstack.types import Matrix, Vector

_PROXIMAL = 1e-9  # of a trace of about 1
_ENDLESS = 1e30  # from here on PIQP takes the end of a row for infinite
_NONE = np.zeros(0, dtype=np.int8)


Library = Callable[[Matrix, Vector, Matrix, Vector, Vector], Vector | str]
"""A call for one level: H, f, rows, the limits of the bounds and then of the rows, lower and upper.
It returns x, which minimises x'Hx/2 + f'x, or why not."""


class EqualityCascade:
    """A cascade whose levels keep those above by equality rows."""

    solves = "one QP per level, those above as equality rows"

    def __init__(self, name: str, library: Library) -> None:
        """Solve each level with a library."""
        self.name = f"{name} cascade"
        self._library = library

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve all levels in order; the last one that was solved if one fails."""
        begun = perf_counter()
        bounds = problem.bounds
        n = bounds.lower.size
        hierarchy = Hierarchy(problem.levels, n)
        chi, reason = np.clip(np.zeros(n), bounds.lower, bounds.upper), ""
        kept: list[tuple[Matrix, Vector, Vector]] = []
        for k, level in enumerate(hierarchy.levels):
            soft = np.flatnonzero(~level.equal)
            found = self._library(*_level(level, soft, kept, (bounds.lower, bounds.upper)))
            if isinstance(found, str):
                reason = f"level {k + 1}: {found}"
                break
            chi = found[:n]
            value = level.matrix @ chi
            lower, upper = value.copy(), value.copy()
            lower[soft] = np.minimum(level.lower[soft], value[soft])
            upper[soft] = np.maximum(level.upper[soft], value[soft])
            kept.append((level.matrix, lower, upper))
        slacks = hierarchy.slacks(hierarchy.residual(chi))
        return answered(chi, slacks, reason, begun)


def _level(
    level: Any, soft: Any, kept: list[tuple[Matrix, Vector, Vector]], bounds: tuple[Vector, Vector]
) -> tuple[Matrix, Vector, Matrix, Vector, Vector]:
    """Return H, f, rows and all limits of a level, with one more variable per inequality row."""
    n, s = level.matrix.shape[1], soft.size
    scale = 1.0 / (level.norm * level.norm)
    equal = level.matrix if not s else level.matrix[level.equal]
    target = level.lower if not s else level.lower[level.equal]
    hessian = np.zeros((n + s, n + s))
    hessian[:n, :n] = scale * (equal.T @ equal)
    hessian[n:, n:] = scale * np.eye(s)
    hessian[np.diag_indices(n + s)] += _PROXIMAL
    gradient = np.concatenate((-scale * (target @ equal), np.zeros(s)))
    rows = [np.hstack((matrix, np.zeros((len(matrix), s)))) for matrix, _, _ in kept]
    rows.append(np.hstack((level.matrix[soft], -np.eye(s))))
    far = np.full(s, np.inf)
    lower = np.concatenate([bounds[0], -far, *(low for _, low, _ in kept), level.lower[soft]])
    upper = np.concatenate([bounds[1], far, *(high for _, _, high in kept), level.upper[soft]])
    return hessian, gradient, np.concatenate(rows), lower, upper


class DaqpHierarchy:
    """DAQP's hierarchical mode: all levels in one call."""

    name = "DAQP hierarchical"
    solves = "all levels in one call"

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve all levels; breaks between the levels are rows from which a new one begins."""
        begun = perf_counter()
        bounds = problem.bounds
        hierarchy = Hierarchy(problem.levels, bounds.lower.size)
        n = bounds.lower.size
        ends = [n, *(n + level.rows.stop for level in hierarchy.levels)]
        lower = np.concatenate((bounds.lower, hierarchy.lower))
        upper = np.concatenate((bounds.upper, hierarchy.upper))
        x, _, flag, _ = daqp.solve(
            None,
            None,
            hierarchy.matrix,
            upper,
            lower,
            np.zeros(lower.size, dtype=np.intc),
            np.array(ends, dtype=np.intc),
            primal_tol=1e-9,
        )
        reason = "" if flag > 0 else f"exit flag {flag}"
        slacks = hierarchy.slacks(hierarchy.residual(x))
        return answered(x, slacks, reason, begun)


def _quadprog(
    hessian: Matrix, gradient: Vector, rows: Matrix, lower: Vector, upper: Vector
) -> Vector | str:
    """Solve by the dual method of Goldfarb and Idnani, with equal limits as its equality rows."""
    whole = np.concatenate((np.eye(gradient.size), rows))
    equal = lower == upper
    low, high = ~equal & (lower > -np.inf), ~equal & (upper < np.inf)
    stacked = np.concatenate((whole[equal], whole[low], -whole[high]))
    ends = np.concatenate((lower[equal], lower[low], -upper[high]))
    count = int(np.count_nonzero(equal))
    try:
        return np.asarray(quadprog.solve_qp(hessian, -gradient, stacked.T, ends, count)[0])
    except ValueError as error:
        return str(error)


def _piqp(
    piqp: Any, hessian: Matrix, gradient: Vector, rows: Matrix, lower: Vector, upper: Vector
) -> Vector | str:
    """Solve by PIQP's proximal interior-point method, without rows that nothing limits.

    It prints three lines about each solve in which a row has no end.
    """
    n = gradient.size
    solver = piqp.DenseSolver()
    solver.settings.eps_abs, solver.settings.eps_rel = 1e-9, 0.0
    equal = lower[n:] == upper[n:]
    limited = (np.abs(lower[n:]) < _ENDLESS) | (np.abs(upper[n:]) < _ENDLESS)
    other = ~equal & limited
    some = (rows[other], lower[n:][other], upper[n:][other]) if other.any() else (None,) * 3
    equalities = (rows[equal], lower[n:][equal])
    solver.setup(hessian, gradient, *equalities, *some, lower[:n], upper[:n])
    status = solver.solve()
    if status != piqp.PIQP_SOLVED:
        return str(status).rsplit(".", maxsplit=1)[-1]
    return np.array(solver.result.x)


def _proxqp(
    hessian: Matrix, gradient: Vector, rows: Matrix, lower: Vector, upper: Vector
) -> Vector | str:
    """Solve by ProxQP's proximal augmented Lagrangian method, dense, bounds as its box."""
    n = gradient.size
    equal = lower[n:] == upper[n:]
    other = ~equal
    solver = proxqp.dense.QP(n, int(np.count_nonzero(equal)), int(np.count_nonzero(other)), True)
    solver.settings.eps_abs, solver.settings.eps_rel = 1e-9, 0.0
    solver.settings.max_iter = 200
    parts = (rows[equal], lower[n:][equal], rows[other], lower[n:][other], upper[n:][other])
    solver.init(hessian, gradient, *parts, lower[:n], upper[:n])
    solver.solve()
    status = solver.results.info.status
    if status != proxqp.QPSolverOutput.PROXQP_SOLVED:
        return str(status.name)
    return np.array(solver.results.x)


def _daqp(
    hessian: Matrix, gradient: Vector, rows: Matrix, lower: Vector, upper: Vector
) -> Vector | str:
    """Solve by DAQP's one-shot call, equal limits marked as equalities."""
    sense = np.where(lower == upper, 5, 0).astype(np.intc)
    x, _, flag, _ = daqp.solve(
        hessian, gradient, rows, upper, lower, sense, primal_tol=1e-9, eps_prox=0.0
    )
    return x if flag > 0 else f"exit flag {flag}"


def answered(chi: Vector, slacks: Vector, reason: str, begun: float) -> Solution:
    """Return a peer's answer as ours are."""
    status = Status.FAILED if reason else Status.SOLVED
    return Solution(chi, slacks, status, reason, _NONE, perf_counter() - begun)


STRICT: tuple[Callable[[], HqpSolver], ...] = (
    DaqpHierarchy,
    lambda: EqualityCascade("DAQP", _daqp),
    lambda: EqualityCascade("quadprog", _quadprog),
    lambda: EqualityCascade("PIQP", partial(_piqp, import_module("piqp"))),
    lambda: EqualityCascade("ProxQP", _proxqp),
)


def installed(
    peers: tuple[Callable[[], HqpSolver], ...],
) -> tuple[list[HqpSolver], list[str]]:
    """Return the peers that can be imported, and the names of the packages that are missing."""
    found, missing = [], []
    for make in peers:
        try:
            found.append(make())
        except ImportError as error:
            missing.append(error.name or str(error))
    return found, missing
