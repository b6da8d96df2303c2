"""Strict hierarchical quadratic programming: T(8) to T(15) behind one interface."""

from lexstack_core.errors import ConfigurationError
from lexstack_core.hqp.blocked import Blocked, Obstacle, blocked, describe
from lexstack_core.hqp.clusters import ClusteredSolver
from lexstack_core.hqp.damping import Damped, Damper
from lexstack_core.hqp.daqp_cascade import DaqpCascade
from lexstack_core.hqp.fallback import FallbackSolver, refusal
from lexstack_core.hqp.oracle import OracleSolver
from lexstack_core.hqp.problem import (
    DAMPED,
    NEAR,
    HqpProblem,
    HqpSolver,
    NearSingular,
    Solution,
    SolverFactory,
    Status,
    near_singularity,
)
from lexstack_core.hqp.proxqp_cascade import ProxqpCascade
from lexstack_core.hqp.quadprog_cascade import QuadprogCascade

SOLVERS: dict[str, SolverFactory] = {
    "daqp": DaqpCascade,
    "proxqp": ProxqpCascade,
    "quadprog": QuadprogCascade,
    "oracle": OracleSolver,
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


__all__ = [
    "DAMPED",
    "DEFAULT_SOLVER",
    "NEAR",
    "SOLVERS",
    "Blocked",
    "ClusteredSolver",
    "Damped",
    "Damper",
    "FallbackSolver",
    "HqpProblem",
    "HqpSolver",
    "NearSingular",
    "Obstacle",
    "Solution",
    "SolverFactory",
    "Status",
    "blocked",
    "describe",
    "make_solver",
    "near_singularity",
    "refusal",
]
