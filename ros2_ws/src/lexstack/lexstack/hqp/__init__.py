"""Strict hierarchical quadratic programming: T(8) to T(15) behind one interface."""

from lexstack.errors import ConfigurationError
from lexstack.hqp.backends.daqp import DaqpCascade
from lexstack.hqp.backends.oracle import OracleLevel, OracleSolver, lexicographic_oracle
from lexstack.hqp.backends.proxqp import ProxqpCascade
from lexstack.hqp.backends.quadprog import QuadprogCascade
from lexstack.hqp.damping import Damped, Damper
from lexstack.hqp.decoupled_solver import ClusteredSolver
from lexstack.hqp.diagnosis import Blocked, Obstacle, blocked, describe
from lexstack.hqp.fallback import FallbackSolver, refusal
from lexstack.hqp.hierarchy import Hierarchy
from lexstack.hqp.problem import (
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

SOLVERS: dict[str, SolverFactory] = {
    "daqp": DaqpCascade,
    "proxqp": ProxqpCascade,
    "quadprog": QuadprogCascade,
    "oracle": OracleSolver,
}
"""The solvers by the name that a configuration uses; the first is the default."""

DEFAULT_SOLVER = "daqp"
"""The one that is used where none is named."""


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
    "DaqpCascade",
    "FallbackSolver",
    "Hierarchy",
    "HqpProblem",
    "HqpSolver",
    "NearSingular",
    "Obstacle",
    "OracleLevel",
    "OracleSolver",
    "ProxqpCascade",
    "QuadprogCascade",
    "Solution",
    "SolverFactory",
    "Status",
    "blocked",
    "describe",
    "lexicographic_oracle",
    "make_solver",
    "near_singularity",
    "refusal",
]
