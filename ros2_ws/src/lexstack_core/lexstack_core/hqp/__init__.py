"""Strict hierarchical quadratic programming: T(8) to T(15) behind one interface."""

from lexstack_core.errors import ConfigurationError
from lexstack_core.hqp.daqp_cascade import DaqpCascade
from lexstack_core.hqp.problem import HqpProblem, HqpSolver, Solution, SolverFactory, Status
from lexstack_core.hqp.proxqp_cascade import ProxqpCascade

SOLVERS: dict[str, SolverFactory] = {
    "daqp": DaqpCascade,
    "proxqp": ProxqpCascade,
}
"""The solvers by the name that a configuration uses; the first is the default."""

DEFAULT_SOLVER = "daqp"


def make_solver(name: str = DEFAULT_SOLVER) -> HqpSolver:
    """Return a new solver; raises ConfigurationError that lists the known names."""
    if name not in SOLVERS:
        known = ", ".join(sorted(SOLVERS))
        raise ConfigurationError(f"hqp solver: unknown {name!r}; known: {known}")
    return SOLVERS[name]()


__all__ = [
    "DEFAULT_SOLVER",
    "SOLVERS",
    "HqpProblem",
    "HqpSolver",
    "Solution",
    "SolverFactory",
    "Status",
    "make_solver",
]
