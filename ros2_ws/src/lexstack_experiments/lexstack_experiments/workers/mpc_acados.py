"""One level of the HTMPC as a problem of acados: C code of it is generated and compiled by row.

Discrete dynamics, an external cost with its Gauss-Newton Hessian, HPIPM with partial condensing.
The state is q, v and the input before. Times are in turns of one step in real time (RTI) and of
SQP to convergence.
"""

from __future__ import annotations

import ctypes
import os
import sys
import tempfile
from pathlib import Path
from time import thread_time
from typing import Any

import acados
import casadi as ca
import numpy as np
from serving import serve, uncollected

_HOME = Path(acados.__file__).parent
sys.path.insert(0, str(_HOME))  # the wheel has its templates as a package inside
os.environ |= {
    "ACADOS_SOURCE_DIR": acados.DIR,
    "ACADOS_PYTHON_INTERFACE_PATH": acados.TEMPLATE_DIR,
    "TERA_PATH": acados.TERA_PATH,
}
for _library in ("libblasfeo", "libhpipm", "libqpOASES_e"):  # acados looks for them by soname
    ctypes.CDLL(f"{acados.LIB_DIR}/{_library}.so", mode=ctypes.RTLD_GLOBAL)
from acados_template import AcadosModel, AcadosOcp, AcadosOcpSolver  # noqa: E402

_ONE, _MANY = 1, 100


def tool(q: ca.SX, joints: list[dict[str, Any]], offset: list[float]) -> ca.SX:
    """Return where the tool of a chain is, (3, 1)."""
    rotation, place = ca.SX.eye(3), ca.SX.zeros(3)
    for k, joint in enumerate(joints):
        place += rotation @ ca.DM(joint["position"])
        rotation = rotation @ ca.DM(joint["rotation"])
        axis = ca.DM(joint["axis"])
        if joint["slides"]:
            place += rotation @ axis * q[k]
            continue
        cross = ca.skew(axis)
        turn = ca.SX.eye(3) + ca.sin(q[k]) * cross + (1.0 - ca.cos(q[k])) * (cross @ cross)
        rotation = rotation @ turn
    return place + rotation @ ca.DM(offset)


def barrier(value: ca.SX, lower: np.ndarray, upper: np.ndarray, given: dict[str, Any]) -> ca.SX:
    """Return the relaxed log barriers of all entries."""
    mu, zeta, total = given["mu"], given["zeta"], ca.SX(0)
    for room in (ca.DM(upper) - value, value - ca.DM(lower)):
        near = 0.5 * (((room - 2.0 * zeta) / zeta) ** 2 - 1.0) - np.log(zeta)
        far = -ca.log(ca.fmax(room, zeta))
        total += mu * ca.sum1(ca.if_else(room > zeta, far, near))
    return total


def written(name: str, given: dict[str, Any], stages: int) -> AcadosOcp:
    """Return the problem of a robot with so many stages."""
    n, dt = len(given["input"]), given["dt"]
    x, u, reference = ca.SX.sym("x", 3 * n), ca.SX.sym("u", n), ca.SX.sym("reference", 3)
    q, v, before = x[:n], x[n : 2 * n], x[2 * n :]
    error = tool(q, given["joints"], given["offset"]) - reference
    held = [k for k in range(n) if np.isfinite(given["upper"][k])]
    lower, upper = (np.array(given[key])[held] for key in ("lower", "upper"))
    speeds, most = np.array(given["velocities"]), np.array(given["accelerations"])
    change = u - before
    inputs = 0.5 * (ca.dot(ca.DM(given["input"]), u**2) + ca.dot(ca.DM(given["change"]), change**2))
    inputs += barrier(u, -most, most, given)
    state = 0.5 * ca.dot(ca.DM(given["velocity"]), v**2) + barrier(v, -speeds, speeds, given)
    state += barrier(q[held], lower, upper, given)

    def hessian(smooth: ca.SX, weight: float, variables: ca.SX) -> ca.SX:
        jacobian = ca.jacobian(error, variables)
        return ca.hessian(smooth, variables)[0] + weight * jacobian.T @ jacobian

    both, (stage, end) = ca.vertcat(u, x), given["weights"]
    model = AcadosModel()
    model.name, model.x, model.u, model.p = name, x, u, reference
    model.disc_dyn_expr = ca.vertcat(q + dt * v + 0.5 * dt * dt * u, v + dt * u, u)
    model.cost_expr_ext_cost_0 = inputs
    model.cost_expr_ext_cost_custom_hess_0 = hessian(inputs, 0.0, both)
    model.cost_expr_ext_cost = inputs + state + 0.5 * stage * ca.sumsqr(error)
    model.cost_expr_ext_cost_custom_hess = hessian(inputs + state, stage, both)
    model.cost_expr_ext_cost_e = state + 0.5 * end * ca.sumsqr(error)
    model.cost_expr_ext_cost_custom_hess_e = hessian(state, end, x)
    ocp = AcadosOcp()
    ocp.model, ocp.dims.N, ocp.parameter_values = model, stages, np.zeros(3)
    ocp.cost.cost_type_0 = ocp.cost.cost_type = ocp.cost.cost_type_e = "EXTERNAL"
    ocp.constraints.x0 = np.zeros(3 * n)
    options = ocp.solver_options
    options.tf = float(stages)  # costs are multiplied by the length of a stage: one
    options.integrator_type, options.hessian_approx = "DISCRETE", "EXACT"
    options.exact_hess_dyn = options.exact_hess_constr = 0
    options.qp_solver = "PARTIAL_CONDENSING_HPIPM"
    return ocp


class Solves:
    """Rows of problems by name."""

    def __init__(self) -> None:
        """Begin with none."""
        self._rows: dict[str, tuple[dict[int, Any], list[dict[str, Any]], float]] = {}

    def load(
        self, name: str, model: str, numbers: dict[str, Any], states: list[dict[str, Any]]
    ) -> int:
        """Take a row, and generate and compile its code; pinocchio's model is not read here."""
        del model
        stages, solvers = len(states[0]["guess"]), {}
        for most, kind in ((_ONE, "SQP_RTI"), (_MANY, "SQP")):
            ocp = written(f"row{len(self._rows)}_{most}", numbers, stages)
            ocp.solver_options.nlp_solver_type = kind
            if most > _ONE:
                ocp.solver_options.nlp_solver_max_iter = most
                ocp.solver_options.globalization = "MERIT_BACKTRACKING"
            folder = Path(tempfile.mkdtemp())
            os.chdir(folder)
            ocp.code_export_directory = str(folder / "code")
            solvers[most] = AcadosOcpSolver(ocp, json_file=str(folder / "ocp.json"), verbose=False)
        self._rows[name] = solvers, states, numbers["dt"]
        return len(states)

    def solve(self, name: str, iterations: int) -> dict[str, Any]:
        """Return inputs, times with all calls, acados' own [s], iterations and statuses."""
        return uncollected(lambda: self._solve(name, iterations))

    def _solve(self, name: str, iterations: int) -> dict[str, Any]:
        """Solve a row."""
        solvers, states, dt = self._rows[name]
        solver = solvers[iterations]
        found: dict[str, Any] = {"u": [], "times": [], "alone": [], "iterations": [], "failed": []}
        for state in states:
            guess, reference = np.array(state["guess"]), np.array(state["reference"])
            x = np.concatenate((state["q"], state["v"], state["before"]))
            begun = thread_time()
            given(solver, x, guess, reference, dt)
            status = solver.solve()
            inputs = [solver.get(k, "u") for k in range(len(guess))]
            found["times"].append(thread_time() - begun)
            found["u"].append(np.array(inputs).tolist())
            found["alone"].append(float(np.sum(solver.get_stats("time_tot"))))
            found["iterations"].append(int(np.max(solver.get_stats("sqp_iter"))))
            found["failed"].append(status not in {0, 2} if iterations == _ONE else status != 0)
        return found


def given(solver: Any, x: np.ndarray, guess: np.ndarray, reference: np.ndarray, dt: float) -> None:
    """Give a solver the state, the roll-out of the guess, and the reference."""
    n = guess.shape[1]
    solver.set(0, "lbx", x)
    solver.set(0, "ubx", x)
    for k, u in enumerate(guess):
        solver.set(k, "x", x)
        solver.set(k, "u", u)
        q, v = x[:n], x[n : 2 * n]
        x = np.concatenate((q + dt * v + 0.5 * dt * dt * u, v + dt * u, u))
        solver.set(k + 1, "p", reference[k])
    solver.set(len(guess), "x", x)


if __name__ == "__main__":
    solves = Solves()
    serve({"load": solves.load, "solve": solves.solve})
