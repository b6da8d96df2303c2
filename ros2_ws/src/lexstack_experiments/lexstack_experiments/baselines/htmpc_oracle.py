"""The lexicographic optimum of one HTMPC problem: every level solved to convergence by IPOPT."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError
from lexstack.mpc import CollisionScene, HtmpcConfig, Kind, Objective, Task
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_experiments.baselines.htmpc_casadi import Symbols, parameters_of, program, stepped

_INTERIOR = 1e-6  # m, rad: an interior-point method needs one, also where e* is zero
_OPTIONS = {
    "print_time": False,
    "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-8, "max_iter": 1000},
}


@dataclass(frozen=True, slots=True, eq=False)
class OracleLevel:
    """One converged level.

    Attributes:
        converged: whether IPOPT says so; nothing below counts if not.
        word: IPOPT's own.
        total: J_l, effort and barriers, H(9a).
        costs: J of every task there, H(8).
        u: inputs, shape (N, n).
    """

    converged: bool
    word: str
    total: float
    costs: tuple[float, ...]
    u: Matrix


class HtmpcOracle:
    """Solves H(7) for given kinds of tasks by Algorithm 1.

    The lexicographic constraint is H(12), or H(11) as configured. Its tolerance is a factor of
    delta: 0 is the problem as stated, 1 what H(13) lets pass.
    """

    def __init__(
        self,
        robot: RobotModel,
        config: HtmpcConfig,
        kinds: tuple[Kind, ...],
        spheres: tuple[int, ...] = (),
        radii: tuple[float, ...] = (),
    ) -> None:
        """Generate the programs of all levels."""
        self._robot, self._config, self._kinds = robot, config, kinds
        self._symbols = program(robot, config, kinds, spheres, radii)
        self._states = self._roll_out(self._symbols)
        self._solvers = [self._solver(level) for level in range(len(kinds))]
        self._evaluate = self._evaluation()

    def solve(
        self,
        start: tuple[Vector, Vector, Vector],
        objectives: tuple[Objective, ...],
        guess: Matrix,
        tolerance: float = 0.0,
        around: CollisionScene | None = None,
    ) -> tuple[OracleLevel, ...]:
        """Return all levels up to the first that does not converge.

        Args:
            start: q, v and the input before, shapes (n_q,), (n,) and (n,).
            objectives: of the kinds that the oracle was made for.
            guess: inputs to begin with, shape (N, n).
            tolerance: of H(13), in parts of the configured delta.
            around: obstacles, as many as radii were given.
        """
        if tuple(objective.kind for objective in objectives) != self._kinds:
            raise InputError(f"oracle: made for {self._kinds}")
        tasks = [Task(objective, self._config, self._robot) for objective in objectives]
        parameters = parameters_of(start, objectives, around, self._config.horizon)
        levels: list[OracleLevel] = []
        bounds: list[Vector] = []
        u = guess
        for level, task in enumerate(tasks):
            found, values = self._level(level, u, parameters, bounds)
            levels.append(found)
            if not found.converged:
                break
            u = found.u
            bounds.append(self._bound(task, values[level], tolerance))
        return tuple(levels)

    def _bound(self, task: Task, error: Matrix, tolerance: float) -> Vector:
        """Return how large the guarded values may be below a level with these errors (N, s)."""
        kind = self._config.lexicographic
        if kind == "axis":
            return np.asarray(np.abs(error) + tolerance * task.tolerance + _INTERIOR).reshape(-1)
        costs = task.stage_costs(error) + tolerance * task.stage_tolerance + _INTERIOR**2
        return costs if kind == "stage" else np.array([costs.sum()])

    def _level(
        self, level: int, guess: Matrix, parameters: list[Matrix], bounds: list[Vector]
    ) -> tuple[OracleLevel, list[Matrix]]:
        """Solve one level; returns it, and the errors (N, s) of all tasks there."""
        limits, stages = self._robot.limits, self._config.horizon
        inputs = np.full(guess.size, np.inf)
        hard = np.zeros(0)
        if self._config.hard_limits:
            inputs = np.tile(limits.acceleration, stages)
            hard = np.tile(limits.velocity, stages)
        upper = np.concatenate((*bounds, hard)) if bounds else hard
        lower = -upper
        if self._config.lexicographic != "axis":
            count = sum(map(len, bounds))
            lower[:count] = -np.inf
        positions = self._positions()
        solver = self._solvers[level]
        answer = solver(
            x0=guess.reshape(-1),
            p=ca.vertcat(*(ca.vec(ca.DM(parameter)) for parameter in parameters)),
            lbx=-inputs,
            ubx=inputs,
            lbg=np.concatenate((lower, positions[0])),
            ubg=np.concatenate((upper, positions[1])),
        )
        stats = solver.stats()
        u = np.array(answer["x"]).reshape(stages, -1)
        values = self._evaluate(u.T, *parameters)
        count = len(self._kinds)
        costs = tuple(float(value) for value in values[count:-1])
        found = OracleLevel(
            bool(stats["success"]), stats["return_status"], float(answer["f"]), costs, u
        )
        return found, [np.array(value).T for value in values[:count]]

    def _positions(self) -> NDArray[np.float64]:
        """Return lower and upper position limits over the horizon, where they are constraints."""
        if not self._config.hard_limits:
            return np.zeros((2, 0))
        limits, stages = self._robot.limits, self._config.horizon
        lower, upper = (
            np.tile(limits.position_lower, stages),
            np.tile(limits.position_upper, stages),
        )
        return np.array((lower, upper))

    def _roll_out(self, symbols: Symbols) -> ca.MX:
        """Return the states 1 to N as functions of the inputs, shape (n_q + n, N)."""
        state = symbols.start[: self._robot.nq + self._robot.n]
        states = []
        for k in range(self._config.horizon):
            state = stepped(self._robot, state, symbols.u[:, k], self._config.step)
            states.append(state)
        return ca.horzcat(*states)

    def _condensed(self, *expressions: ca.MX) -> list[ca.MX]:
        """Return expressions with the states replaced by what the inputs make of them."""
        symbols = self._symbols
        return ca.graph_substitute(list(expressions), [symbols.x], [self._states])

    def _solver(self, level: int) -> ca.Function:
        """Return IPOPT's program of one level."""
        symbols = self._symbols
        cost = symbols.costs[level] + symbols.shared_cost
        guarded = [self._guarded(i) for i in range(level)]
        size = self._robot.nq
        first = size - self._robot.n  # what of q has no entry in chi
        hard = []
        if self._config.hard_limits:
            hard = [ca.vec(symbols.x[size:, :]), ca.vec(symbols.x[first:size, :])]
        condensed = self._condensed(cost, ca.vertcat(*guarded, *hard))
        parameters = [symbols.start, symbols.obstacles, *symbols.references]
        described = {
            "x": ca.vec(symbols.u),
            "f": condensed[0],
            "g": condensed[1],
            "p": ca.vertcat(*(ca.vec(parameter) for parameter in parameters)),
        }
        return ca.nlpsol(f"level{level}", "ipopt", described, _OPTIONS)

    def _guarded(self, level: int) -> ca.MX:
        """Return the values that levels below must not raise, shape (r, 1)."""
        symbols, kind = self._symbols, self._config.lexicographic
        if kind == "axis":
            return ca.vec(symbols.errors[level])
        if kind == "sum":
            return symbols.costs[level]
        raise InputError("oracle: lexicographic: only 'axis' and 'sum' are written here")

    def _evaluation(self) -> ca.Function:
        """Return a function for all errors, all costs and the shared_cost."""
        symbols = self._symbols
        outputs = self._condensed(*symbols.errors, *symbols.costs, symbols.shared_cost)
        inputs = [symbols.u, symbols.start, symbols.obstacles, *symbols.references]
        return ca.Function("evaluate", inputs, outputs)
