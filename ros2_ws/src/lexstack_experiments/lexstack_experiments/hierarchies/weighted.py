"""What libraries without strict levels make of a hierarchy: one QP with weights.

Pink, mink and placo get the same weighted problem, their own: every level is a task, its cost falls
by ten from level to level, and the bounds are hard. So a level below costs those above something,
by design: their excess says how much. None of them is strict, whatever its weights are.
"""

from __future__ import annotations

from importlib import import_module
from time import perf_counter
from typing import Any

import mujoco
import numpy as np
import pinocchio

from lexstack.hqp import Hierarchy, HqpProblem, Solution
from lexstack.types import Matrix, Vector
from lexstack_experiments.hierarchies.peers import answered

FALL = 10.0
"""By which a cost is divided from level to level."""


class Weighted:
    """One weighted QP for all levels; a library's call is in ``_chi``."""

    name = ""
    solves = f"one QP, costs 1, 1/{FALL:g}, 1/{FALL * FALL:g}, ... by level"

    def solve(self, problem: HqpProblem, warm: Solution | None = None) -> Solution:
        """Solve once (equality rows only); ``warm`` is of no use."""
        begun = perf_counter()
        lower, upper = problem.bounds.lower, problem.bounds.upper
        hierarchy = Hierarchy(problem.levels, lower.size)
        rows = [(level.matrix, level.lower) for level in hierarchy.levels]
        found = self._chi(rows, lower, upper)
        chi, reason = (np.zeros(lower.size), found) if isinstance(found, str) else (found, "")
        return answered(chi, hierarchy.slacks(hierarchy.residual(chi)), reason, begun)

    def _chi(self, rows: list[tuple[Matrix, Vector]], lower: Vector, upper: Vector) -> Vector | str:
        """Return chi, or why there is none."""
        raise NotImplementedError


class Pink(Weighted):
    """Pink's ``solve_ik``."""

    name = "Pink, weighted"

    def __init__(self) -> None:
        """Import it; raises ImportError where it is not installed."""
        self._pink = import_module("pink")
        self._configurations: dict[int, Any] = {}

    def _chi(self, rows: list[tuple[Matrix, Vector]], lower: Vector, upper: Vector) -> Vector | str:
        n = lower.size
        if n not in self._configurations:
            self._configurations[n] = self._slides(n)
        tasks = [_Task(*row, FALL**-k) for k, row in enumerate(rows)]
        limits = [_Limit(lower, upper, tuple)]
        try:
            return np.asarray(
                self._pink.solve_ik(
                    self._configurations[n], tasks, 1.0, "quadprog", limits=limits,
                    safety_break=False,
                )
            )  # fmt: skip
        except self._pink.exceptions.PinkError as error:
            return f"{error}".splitlines()[0]

    def _slides(self, n: int) -> Any:
        """Return a configuration of n independent joints: the Jacobians come with the tasks."""
        model = pinocchio.Model()
        for i in range(n):
            place = pinocchio.SE3.Identity()
            model.addJoint(0, pinocchio.JointModelPX(), place, f"joint_{i}")
        return self._pink.Configuration(model, model.createData(), np.zeros(n))


class Mink(Weighted):
    """mink's ``solve_ik``."""

    name = "mink, weighted"

    def __init__(self) -> None:
        """Import it; raises ImportError where it is not installed."""
        self._mink = import_module("mink")
        self._constraint = import_module("mink.limits").Constraint
        self._configurations: dict[int, Any] = {}

    def _chi(self, rows: list[tuple[Matrix, Vector]], lower: Vector, upper: Vector) -> Vector | str:
        n = lower.size
        if n not in self._configurations:
            self._configurations[n] = self._slides(n)
        tasks = [_Task(*row, FALL**-k) for k, row in enumerate(rows)]
        limits = [_Limit(lower, upper, lambda pair: self._constraint(*pair))]
        try:
            return np.asarray(
                self._mink.solve_ik(self._configurations[n], tasks, 1.0, "daqp", limits=limits)
            )
        except self._mink.exceptions.MinkError as error:
            return f"{error}".splitlines()[0]

    def _slides(self, n: int) -> Any:
        """Return a configuration of n independent joints."""
        spec = mujoco.MjSpec()
        for i in range(n):
            body = spec.worldbody.add_body(name=f"body_{i}")
            body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
            body.add_joint(name=f"joint_{i}", type=mujoco.mjtJoint.mjJNT_SLIDE)
        return self._mink.Configuration(spec.compile())


class _Task:
    """What ``solve_ik`` asks of a task: Pink for the first answer, mink for the second."""

    def __init__(self, matrix: Matrix, target: Vector, cost: float) -> None:
        self._matrix, self._target, self._cost = matrix, target, cost

    def compute_qp_objective(self, _configuration: Any) -> tuple[Matrix, Vector]:
        """Return H and c, as Pink's own tasks do."""
        weighted = self._cost * self._cost * self._matrix.T
        return weighted @ self._matrix, -weighted @ self._target

    def compute_qp_residual(self, _configuration: Any) -> tuple[Matrix, Vector, float]:
        """Return weighted rows and targets, and no damping, as mink's own tasks do."""
        return self._cost * self._matrix, self._cost * self._target, 0.0


class _Limit:
    """What ``solve_ik`` asks of a limit, for a box."""

    def __init__(self, lower: Vector, upper: Vector, pack: Any) -> None:
        unit = np.eye(lower.size)
        self._rows, self._ends = np.vstack((unit, -unit)), np.concatenate((upper, -lower))
        self._pack = pack

    def compute_qp_inequalities(self, _configuration: Any, _dt: float) -> Any:
        """Return G and h."""
        return self._pack((self._rows, self._ends))


WEIGHTED = (Pink, Mink)
"""Those that fit the packages of this project; placo is a worker of its own."""
