"""One level of the HTMPC as a problem of crocoddyl: its FDDP solver, our costs as Python models.

crocoddyl has no relaxed barrier, no changes of the input and no input that is an acceleration held
over a stage, so these are written here as action models in Python, as its users do; pinocchio and
the solver are compiled. The state is q, v and the input before.
"""

from __future__ import annotations

from time import thread_time
from typing import Any

import crocoddyl
import numpy as np
import pinocchio
from serving import serve, uncollected


class Costs:
    """The numbers of the problem, and the barrier of H(7d).

    Attributes:
        n: joints.
        dt: length of a stage [s].
        spent: thread's time in the models so far [s].
    """

    def __init__(self, model: pinocchio.Model, given: dict[str, Any]) -> None:
        """Take weights and limits by name."""
        self.model, self.data, self.n = model, model.createData(), model.nv
        self.dt, self.mu, self.zeta = given["dt"], given["mu"], given["zeta"]
        names = ("velocity", "input", "change", "lower", "upper", "velocities", "accelerations")
        for name in names:
            setattr(self, name, np.array(given[name], dtype=float))
        self.joint, self.offset = given["joint"], np.array(given["offset"])
        self.bounded = np.isfinite(self.upper)
        self.lower, self.upper = self.lower[self.bounded], self.upper[self.bounded]
        self.spent = 0.0

    def barrier(
        self, value: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Return value, first and second derivatives by entry."""
        total, first, second = 0.0, np.zeros_like(value), np.zeros_like(value)
        for room, sign in ((upper - value, -1.0), (value - lower, 1.0)):
            far = room > self.zeta
            near = (room - 2.0 * self.zeta) / self.zeta
            safe = np.where(far, room, 1.0)
            total += np.where(far, -np.log(safe), 0.5 * (near**2 - 1.0) - np.log(self.zeta)).sum()
            first += sign * np.where(far, -1.0 / safe, near / self.zeta)
            second += np.where(far, 1.0 / safe**2, 1.0 / self.zeta**2)
        return self.mu * total, self.mu * first, self.mu * second

    def tool(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return where the tool is, and the Jacobian of that, (3, n)."""
        pinocchio.computeJointJacobians(self.model, self.data, q)
        place = self.data.oMi[self.joint]
        arm = place.rotation @ self.offset
        jacobian = pinocchio.getJointJacobian(
            self.model, self.data, self.joint, pinocchio.LOCAL_WORLD_ALIGNED
        )
        return place.translation + arm, jacobian[:3] - pinocchio.skew(arm) @ jacobian[3:]

    def state(
        self, x: np.ndarray, reference: np.ndarray, weight: float
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Return cost, gradient and Gauss-Newton Hessian of a state 1 to N in (q, v)."""
        n, q, v = self.n, x[: self.n], x[self.n : 2 * self.n]
        place, jacobian = self.tool(q)
        error = place - reference
        cost = 0.5 * weight * error @ error + 0.5 * self.velocity @ v**2
        gradient, hessian = np.zeros(3 * n), np.zeros((3 * n, 3 * n))
        gradient[:n], gradient[n : 2 * n] = weight * error @ jacobian, self.velocity * v
        hessian[:n, :n] = weight * jacobian.T @ jacobian
        diagonal = np.zeros(3 * n)
        diagonal[n : 2 * n] = self.velocity
        held = np.flatnonzero(self.bounded)
        for places, value, lower, upper in (
            (held, q[held], self.lower, self.upper),
            (np.arange(n, 2 * n), v, -self.velocities, self.velocities),
        ):
            some, first, second = self.barrier(value, lower, upper)
            cost += some
            gradient[places] += first
            diagonal[places] += second
        hessian[np.diag_indices(3 * n)] += diagonal
        return cost, gradient, hessian


class Stage(crocoddyl.ActionModelAbstract):
    """A stage: the cost of its state, unless it is the first, and of its input."""

    def __init__(self, costs: Costs, reference: np.ndarray | None, weight: float) -> None:
        """Without a reference the state is the given one, and costs nothing."""
        n = costs.n
        crocoddyl.ActionModelAbstract.__init__(self, crocoddyl.StateVector(3 * n), n, 1)
        self._costs, self._reference, self._weight = costs, reference, weight
        dt, eye = costs.dt, np.eye(n)
        self._fx = np.zeros((3 * n, 3 * n))
        self._fx[:n, :n] = self._fx[n : 2 * n, n : 2 * n] = eye
        self._fx[:n, n : 2 * n] = dt * eye
        self._fu = np.vstack((0.5 * dt * dt * eye, dt * eye, eye))

    def calc(self, data: Any, x: np.ndarray, u: np.ndarray | None = None) -> None:
        """Set cost and next state."""
        begun = thread_time()
        costs, n = self._costs, self._costs.n
        data.cost = 0.0
        if self._reference is not None:
            data.cost = costs.state(x, self._reference, self._weight)[0]
        if u is None or not u.size:
            data.xnext = x
        else:
            data.xnext = self._fx @ x + self._fu @ u
            change = u - x[2 * n :]
            data.cost += 0.5 * (costs.input @ u**2 + costs.change @ change**2)
            data.cost += costs.barrier(u, -costs.accelerations, costs.accelerations)[0]
        costs.spent += thread_time() - begun

    def calcDiff(self, data: Any, x: np.ndarray, u: np.ndarray | None = None) -> None:  # noqa: N802
        """Set the derivatives of both."""
        begun = thread_time()
        costs, n = self._costs, self._costs.n
        lx, lxx = np.zeros(3 * n), np.zeros((3 * n, 3 * n))
        if self._reference is not None:
            _, lx, lxx = costs.state(x, self._reference, self._weight)
        if u is not None and u.size:
            change = costs.change * (u - x[2 * n :])
            _, first, second = costs.barrier(u, -costs.accelerations, costs.accelerations)
            lx[2 * n :] -= change
            lxx[2 * n :, 2 * n :] += np.diag(costs.change)
            data.Lu = costs.input * u + change + first
            data.Luu = np.diag(costs.input + costs.change + second)
            lxu = np.zeros((3 * n, n))
            lxu[2 * n :] = -np.diag(costs.change)
            data.Lxu, data.Fx, data.Fu = lxu, self._fx, self._fu
        data.Lx, data.Lxx = lx, lxx
        costs.spent += thread_time() - begun


class Solves:
    """Rows of problems by name."""

    def __init__(self) -> None:
        """Begin with none."""
        self._rows: dict[str, tuple[Costs, list[dict[str, Any]], list[float]]] = {}

    def load(
        self, name: str, model: str, numbers: dict[str, Any], states: list[dict[str, Any]]
    ) -> str:
        """Take a row: the model as pinocchio writes it, numbers, and the states with guesses."""
        loaded = pinocchio.Model()
        loaded.loadFromString(model)
        self._rows[name] = Costs(loaded, numbers), states, numbers["weights"]
        return str(crocoddyl.__version__)

    def solve(self, name: str, iterations: int) -> dict[str, Any]:
        """Return inputs, times with and without the models [s], and iterations, by state."""
        return uncollected(lambda: self._solve(name, iterations))

    def _solve(self, name: str, iterations: int) -> dict[str, Any]:
        """Solve a row."""
        costs, states, weights = self._rows[name]
        found: dict[str, Any] = {"u": [], "times": [], "alone": [], "iterations": [], "failed": []}
        for state in states:
            solver, xs, us = problem(costs, state, weights)
            costs.spent, begun = 0.0, thread_time()
            solver.solve(xs, us, iterations, False)
            found["times"].append(thread_time() - begun)
            found["alone"].append(found["times"][-1] - costs.spent)
            found["failed"].append(not np.isfinite(solver.cost))
            found["iterations"].append(solver.iter)
            found["u"].append(np.array(solver.us.tolist()).tolist())
        return found


def problem(costs: Costs, state: dict[str, Any], weights: list[float]) -> tuple[Any, list, list]:
    """Return a solver with the guess: the roll-out of inputs."""
    reference, guess = np.array(state["reference"]), np.array(state["guess"])
    stages = [Stage(costs, None, 0.0)]
    stages += [Stage(costs, reference[k], weights[0]) for k in range(len(guess) - 1)]
    end = Stage(costs, reference[-1], weights[1])
    x = np.concatenate((state["q"], state["v"], state["before"]))
    shooting = crocoddyl.ShootingProblem(x, stages, end)
    solver = crocoddyl.SolverFDDP(shooting)
    solver.th_stop = 1e-9
    us = list(guess)
    return solver, list(shooting.rollout(us)), us


if __name__ == "__main__":
    solves = Solves()
    serve({"load": solves.load, "solve": solves.solve})
