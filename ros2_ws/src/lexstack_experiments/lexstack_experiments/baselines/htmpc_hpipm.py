"""One level of the HTMPC by HPIPM: CasADi evaluates, HPIPM solves the QP stage by stage.

The problem, the Gauss-Newton Hessian and the line search are those of the paper's way. The QP is
written as HPIPM wants it: the input before is part of the state, so that the changes of H(10) stay
within a stage, and the QP object is made once.
"""

from __future__ import annotations

from dataclasses import replace
from time import thread_time

import casadi as ca
import numpy as np

from lexstack.mpc import HtmpcConfig, Kind
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_experiments.baselines.htmpc_casadi import program, weights_of
from lexstack_experiments.baselines.htmpc_paper import PaperHtmpc

_FREE = 1e6  # HPIPM has bounds on every unknown; infinite ones it does not solve


class HpipmHtmpc(PaperHtmpc):
    """HPIPM for the first level, for a robot whose base is not differential.

    Attributes:
        qp_seconds: thread's time in HPIPM through CasADi, of all solves so far.
    """

    def __init__(self, robot: RobotModel, config: HtmpcConfig, kind: Kind) -> None:
        """Make the functions and the QP."""
        super().__init__(robot, config, (kind,), "hpipm")
        self.qp_seconds = 0.0
        self._evaluate, self._conic = _structured(robot, config, kind)

    def _level(self, level: int, u: Matrix, given: list[Matrix], best: list[Vector]) -> Matrix:
        """Return the inputs after one SQP iteration."""
        n = self._n
        q, v = self._horizon.roll_out(given[0][:n], given[0][n : 2 * n], u)
        stages = np.hstack((u, q[1:], v[1:], u))  # input, then the state that it leads to
        hessian, gradient, rows, gaps = self._evaluate(stages.ravel(), given[0], given[2])
        begun = thread_time()
        answer = self._conic(
            h=hessian, g=gradient, a=rows, lba=-gaps, uba=-gaps, lbx=-_FREE, ubx=_FREE
        )
        self.qp_seconds += thread_time() - begun
        if not self._conic.stats()["success"]:
            self.failures += 1
            return u
        step = answer["x"].full().reshape(len(u), 4 * n)[:, :n]
        # The paper's gradient is in other unknowns; the slope along the step is the same.
        slope = float(gradient.full().ravel() @ answer["x"].full().ravel())
        return self._search(level, u, step, slope, given, best)


def _structured(
    robot: RobotModel, config: HtmpcConfig, kind: Kind
) -> tuple[ca.Function, ca.Function]:
    """Return Hessian, gradient, rows and gaps of the stages, and the QP of their structure.

    The unknowns are, stage by stage, the input and the state after it: q, v, and that input again.
    """
    n, stages = robot.n, config.horizon
    effort = config.effort
    plain = replace(config, effort=replace(effort, base_change=0.0, arm_change=0.0))
    symbols = program(robot, plain, (kind,))
    z = ca.MX.sym("z", 4 * n, stages)
    u, x, kept = z[:n, :], z[n : 3 * n, :], z[3 * n :, :]
    error, task, smooth, gaps = ca.substitute(
        [symbols.errors[0], symbols.costs[0], symbols.smooth, symbols.gaps],
        [symbols.x, symbols.u],
        [x, u],
    )
    first = robot.arm.start
    weights = ca.DM([effort.base_change] * first + [effort.arm_change] * (n - first))
    changes = u - ca.horzcat(symbols.start[2 * n :], kept[:, :-1])
    smooth += 0.5 * ca.sum1(weights * ca.sum2(changes**2))
    flat = ca.vec(z)
    jacobian = ca.jacobian(ca.vec(error), flat)
    tracking = jacobian.T @ ca.diag(ca.DM(weights_of(config, kind).T.ravel())) @ jacobian
    hessian = ca.hessian(smooth, flat)[0] + tracking
    # HPIPM wants the new state with a minus.
    missing = -ca.vec(ca.vertcat(gaps, kept - u))
    rows = ca.jacobian(missing, flat)
    inputs = [z, symbols.start, symbols.references[0]]
    outputs = [hessian, ca.gradient(task + smooth, flat), rows, missing]
    # z as one vector, so that the caller's array needs no turning.
    vector = ca.MX.sym("vector", z.numel())
    evaluate = ca.Function("evaluate", inputs, outputs)
    called = evaluate(ca.reshape(vector, *z.shape), *inputs[1:])
    whole = ca.Function("stages", [vector, *inputs[1:]], called)
    structure = {"h": hessian.sparsity(), "a": rows.sparsity()}
    sizes = {
        "N": stages,
        "nx": [0] + [3 * n] * stages,
        "nu": [n] * stages + [0],
        "ng": [0] * (stages + 1),
    }
    return whole, ca.conic("stages", "hpipm", structure, {"error_on_fail": False, **sizes})
