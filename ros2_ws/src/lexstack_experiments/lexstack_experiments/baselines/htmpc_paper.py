"""The HTMPC as its paper runs it: CasADi evaluates, and builds the QP object anew for every QP.

Inputs and states are unknowns, the dynamics are constraints, and the matrices are sparse. The
problem, its levels and its line search are those of the fast path without its additions (hard
limits, bent steps, resuming): H(12) alone.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from time import perf_counter
from typing import Any

import casadi as ca
import numpy as np

from lexstack.mpc import CollisionScene, Horizon, HtmpcConfig, Kind, Objective
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_experiments.baselines.htmpc_casadi import (
    Symbols,
    curvature,
    parameters_of,
    program,
    weights_of,
)

SOLVERS: dict[str, dict[str, object]] = {
    "gurobi": {},
    "osqp": {"osqp": {"verbose": False, "eps_abs": 1e-6, "eps_rel": 1e-6, "max_iter": 20000}},
    "proxqp": {},
    "qrqp": {"print_iter": False, "print_header": False, "print_info": False},
}
"""QP solvers with their options: the paper's Gurobi, through its own package, whose restricted
licence CasADi cannot use; then what CasADi ships. OSQP gets Gurobi's tolerance; with its own of
1e-3 it violates H(12) by millimetres, as much as delta. Of those that are not here daqp wants a
definite Hessian, ipqp and highs fail on some, qpoases takes seconds."""


LICENSED = 200
"""Unknowns of a QP that Gurobi's restricted licence allows."""


class PaperHtmpc:
    """The paper's way, for one robot with given kinds of tasks.

    Attributes:
        failures: QPs that were not solved so far.
    """

    def __init__(
        self,
        robot: RobotModel,
        config: HtmpcConfig,
        kinds: tuple[Kind, ...],
        solver: str,
        *,
        spheres: tuple[int, ...] = (),
        radii: tuple[float, ...] = (),
    ) -> None:
        """Make the functions; the QP objects are made in ``solve``."""
        self._config, self._solver = config, solver
        self._n = robot.n
        self._horizon = Horizon(config.horizon, config.step)
        self._tolerances = [
            config.ee.tolerance if kind.startswith("ee") else config.base.tolerance
            for kind in kinds
        ]
        symbols = program(robot, config, kinds, spheres, radii)
        unknowns, symbols = _stacked(symbols)
        inputs = [unknowns, symbols.start, symbols.obstacles, *symbols.references]
        self._quadratics = [
            ca.Function("quadratic", inputs, outputs)
            for outputs in _quadratics(config, kinds, symbols, unknowns)
        ]
        self._costs = [
            ca.Function("cost", inputs, [task + symbols.shared_cost]) for task in symbols.costs
        ]
        errors = [ca.vec(error) for error in symbols.errors]
        self._errors = [ca.Function("error", inputs, [error]) for error in errors]
        self._rows = [
            ca.Function("rows", inputs, [ca.jacobian(error, unknowns)]) for error in errors
        ]
        gaps = ca.vec(symbols.gaps)
        self._dynamics = ca.Function("dynamics", inputs, [ca.jacobian(gaps, unknowns)])
        self._condensed = _condensed(self._horizon, robot.n)
        self.failures = 0

    def solve(
        self,
        start: tuple[Vector, Vector, Vector],
        objectives: tuple[Objective, ...],
        guess: Matrix,
        around: CollisionScene | None = None,
    ) -> tuple[Matrix, float]:
        """Return the inputs (N, n) and the wall time [s] of one solve of all levels.

        Args:
            start: q, v and the input before, shapes (n,).
            objectives: of the kinds that it was made for.
            guess: inputs to begin with, shape (N, n).
            around: obstacles, as many as radii were given.
        """
        begun = perf_counter()
        given = parameters_of(start, objectives, around, self._config.horizon)
        u, best = guess, list[Vector]()
        for level in range(len(objectives)):
            u = self._level(level, u, given, best)
            point = self._point(u, given)
            best.append(np.abs(np.array(self._errors[level](*point)).ravel()))
        return u, perf_counter() - begun

    def cost(
        self,
        start: tuple[Vector, Vector, Vector],
        objectives: tuple[Objective, ...],
        u: Matrix,
        around: CollisionScene | None = None,
    ) -> float:
        """Return the cost H(9a) of the first level at inputs (N, n); arguments as of ``solve``."""
        given = parameters_of(start, objectives, around, self._config.horizon)
        return float(self._costs[0](*self._point(u, given)))

    def _point(self, u: Matrix, given: list[Matrix]) -> list[Matrix]:
        """Return the arguments of all functions at inputs (N, n)."""
        n = self._n
        q, v = self._horizon.roll_out(given[0][:n], given[0][n : 2 * n], u)
        states = np.hstack((q[1:], v[1:])).ravel()
        return [np.concatenate((states, u.ravel())), *given]

    def _level(self, level: int, u: Matrix, given: list[Matrix], best: list[Vector]) -> Matrix:
        """Return the inputs after one SQP iteration of a level."""
        point = self._point(u, given)
        hessian, gradient = self._quadratics[level](*point)
        dynamics = self._dynamics(*point)
        rows = [dynamics] + [self._rows[i](*point) for i in range(level)]
        a = ca.vertcat(*rows)
        equal = np.zeros(dynamics.size1())
        lower, upper = [equal], [equal]
        for i in range(level):
            error = np.array(self._errors[i](*point)).ravel()
            lower.append(np.minimum(-best[i] - error, 0.0))
            upper.append(np.maximum(best[i] - error, 0.0))
        bounds = (np.concatenate(lower), np.concatenate(upper))
        if self._solver == "gurobi":
            step = _gurobi(self._condensed, (hessian, gradient), a[equal.size :, :], bounds)
        else:
            step = _conic(self._solver, hessian, gradient, a, bounds)
        if step is None:
            self.failures += 1
            return u
        slope = float(gradient.full().ravel() @ step)
        direction = step[-u.size :].reshape(u.shape)
        return self._search(level, u, direction, slope, given, best)

    def _search(
        self,
        level: int,
        u: Matrix,
        direction: Matrix,
        slope: float,
        given: list[Matrix],
        best: list[Vector],
    ) -> Matrix:
        """Return the first trial that neither H(13) nor the cost refuses; without one, u."""
        rules = self._config.line_search
        cost = float(self._costs[level](*self._point(u, given)))
        alpha = 1.0
        for _ in range(rules.trials):
            tried = u + alpha * direction
            point = self._point(tried, given)
            kept = all(
                np.all(
                    np.abs(np.array(self._errors[i](*point)).ravel())
                    <= best[i] + self._tolerances[i]
                )
                for i in range(level)
            )
            fell = float(self._costs[level](*point)) <= cost + rules.descent * alpha * slope
            if kept and fell:
                return tried
            alpha *= rules.beta
        return u


def _conic(
    name: str, hessian: ca.DM, gradient: ca.DM, rows: ca.DM, bounds: tuple[Vector, Vector]
) -> Vector | None:
    """Return the optimum of a QP by CasADi, its object made anew as the paper's code does."""
    structure = {"h": hessian.sparsity(), "a": rows.sparsity()}
    conic = ca.conic("qp", name, structure, {"error_on_fail": False, **SOLVERS[name]})
    answer = conic(h=hessian, g=gradient, a=rows, lba=bounds[0], uba=bounds[1])
    return answer["x"].full().ravel() if conic.stats()["success"] else None


def _gurobi(
    condensed: Matrix, cost: tuple[ca.DM, ca.DM], rows: ca.DM, bounds: tuple[Vector, Vector]
) -> Vector | None:
    """Return the optimum of a QP by Gurobi, its model made anew.

    Its restricted licence allows 200 unknowns, so the states are eliminated first.

    Args:
        condensed: unknowns by inputs, shape (3 N n, N n).
        cost: Hessian and gradient in the unknowns.
        rows: of the levels above alone, in the unknowns.
        bounds: of the dynamics, then of these rows.
    """
    import gurobipy  # noqa: PLC0415  (optional: not in the lock)

    model = gurobipy.Model(env=_environment())
    u = model.addMVar(condensed.shape[1], lb=-np.inf)
    hessian = condensed.T @ (cost[0].sparse() @ condensed)
    model.setObjective(0.5 * (u @ hessian @ u) + (cost[1].full().ravel() @ condensed) @ u)
    if rows.size1():
        matrix = rows.sparse() @ condensed
        model.addConstr(matrix @ u >= bounds[0][-rows.size1() :])
        model.addConstr(matrix @ u <= bounds[1][-rows.size1() :])
    model.optimize()
    return condensed @ u.X if model.Status == gurobipy.GRB.OPTIMAL else None


@cache
def _environment() -> Any:
    """Return Gurobi's environment, silent; it looks for a licence once."""
    import gurobipy  # noqa: PLC0415

    return gurobipy.Env(params={"OutputFlag": 0})


def _condensed(horizon: Horizon, n: int) -> Matrix:
    """Return the unknowns, states then inputs, by the inputs: shape (3 N n, N n)."""
    stages = horizon.stages
    states = np.zeros((stages, 2 * n, stages, n))
    joint = np.arange(n)
    states[:, joint, :, joint] = horizon.to_position
    states[:, n + joint, :, joint] = horizon.to_velocity
    return np.vstack((states.reshape(2 * n * stages, stages * n), np.eye(stages * n)))


def _stacked(symbols: Symbols) -> tuple[ca.MX, Symbols]:
    """Return one vector of unknowns, states then inputs, and the program written in it."""
    states = symbols.x.numel()
    unknowns = ca.MX.sym("unknowns", states + symbols.u.numel())
    x = ca.reshape(unknowns[:states], *symbols.x.shape)
    u = ca.reshape(unknowns[states:], *symbols.u.shape)
    count = len(symbols.errors)
    written = ca.substitute(
        [
            *symbols.errors,
            *symbols.costs,
            symbols.gaps,
            symbols.shared_cost,
            symbols.rooms,
            symbols.smooth,
        ],
        [symbols.x, symbols.u],
        [x, u],
    )
    gaps, shared_cost, rooms, smooth = written[2 * count :]
    return unknowns, replace(
        symbols,
        x=x,
        u=u,
        errors=tuple(written[:count]),
        costs=tuple(written[count : 2 * count]),
        gaps=gaps,
        shared_cost=shared_cost,
        rooms=rooms,
        smooth=smooth,
    )


def _quadratics(
    config: HtmpcConfig, kinds: tuple[Kind, ...], symbols: Symbols, unknowns: ca.MX
) -> list[list[ca.MX]]:
    """Return, for each level, Gauss-Newton Hessian and gradient in the unknowns."""
    shared = ca.hessian(symbols.smooth, unknowns)[0]
    if symbols.rooms.numel():
        rooms = ca.jacobian(symbols.rooms, unknowns)
        shared += rooms.T @ ca.diag(curvature(config.collision, symbols.rooms)) @ rooms
    quadratics = []
    for kind, task, error in zip(kinds, symbols.costs, symbols.errors, strict=True):
        jacobian = ca.jacobian(ca.vec(error), unknowns)
        weights = ca.diag(ca.DM(weights_of(config, kind).T.ravel()))
        slope = ca.gradient(task + symbols.shared_cost, unknowns)
        quadratics.append([shared + jacobian.T @ weights @ jacobian, slope])
    return quadratics
