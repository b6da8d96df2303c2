"""The solvers by name: a new one is its file and one line here."""

from __future__ import annotations

import lexstack.hqp
from lexstack.errors import ConfigurationError
from lexstack.hqp.backends.daqp import DaqpCascade
from lexstack.hqp.backends.proxqp import ProxqpCascade
from lexstack.hqp.backends.quadprog import QuadprogCascade
from lexstack.hqp.decoupled_solver import ClusteredSolver
from lexstack.hqp.fallback import FallbackSolver
from lexstack.hqp.problem import HqpSolver, SolverFactory


def _oracle() -> HqpSolver:
    """Return the oracle, for comparisons: it needs scipy.optimize, which takes 0.5 s to load."""
    return lexstack.hqp.OracleSolver()


SOLVERS: dict[str, SolverFactory] = {
    "daqp": DaqpCascade,
    "proxqp": ProxqpCascade,
    "quadprog": QuadprogCascade,
    "oracle": _oracle,
}
"""The solvers by the name that a configuration uses; the first is the default."""

DEFAULT_SOLVER = "daqp"
"""The solver of whoever names none."""


def make_solver(name: str = DEFAULT_SOLVER) -> HqpSolver:
    """Return a new solver that takes clusters apart and has another one to fall back on.

    The order of fallback: the named solver; one of another library, without guesses; and then the
    solution says that it failed, on which the controller brakes.

    Raises:
        ConfigurationError: an unknown name; it lists the known ones.
    """
    if name not in SOLVERS:
        known = ", ".join(sorted(SOLVERS))
        raise ConfigurationError(f"hqp solver: unknown {name!r}; known: {known}")
    second = DaqpCascade if name == "proxqp" else ProxqpCascade
    return ClusteredSolver(FallbackSolver(SOLVERS[name](), second(guesses=False)))
