"""Strict hierarchical quadratic programming: T(8) to T(15) behind one interface."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.hqp.backends.daqp import DaqpCascade
    from lexstack.hqp.backends.oracle import OracleLevel, OracleSolver, lexicographic_oracle
    from lexstack.hqp.backends.proxqp import ProxqpCascade
    from lexstack.hqp.backends.quadprog import QuadprogCascade
    from lexstack.hqp.damping import Damped, Damper
    from lexstack.hqp.decoupled_solver import ClusteredSolver
    from lexstack.hqp.diagnosis import Blocked, Obstacle, describe, explain_unmet_levels
    from lexstack.hqp.fallback import FallbackSolver, rejection_reason
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
    from lexstack.hqp.solvers import DEFAULT_SOLVER, SOLVERS, make_solver
else:
    __getattr__ = on_demand(
        __name__,
        {
            "backends.daqp": "DaqpCascade",
            "backends.oracle": "OracleLevel OracleSolver lexicographic_oracle",
            "backends.proxqp": "ProxqpCascade",
            "backends.quadprog": "QuadprogCascade",
            "damping": "Damped Damper",
            "decoupled_solver": "ClusteredSolver",
            "diagnosis": "Blocked Obstacle explain_unmet_levels describe",
            "fallback": "FallbackSolver rejection_reason",
            "hierarchy": "Hierarchy",
            "problem": "DAMPED NEAR HqpProblem HqpSolver NearSingular "
            "Solution SolverFactory Status near_singularity",
            "solvers": "DEFAULT_SOLVER SOLVERS make_solver",
        },
    )

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
    "describe",
    "explain_unmet_levels",
    "lexicographic_oracle",
    "make_solver",
    "near_singularity",
    "rejection_reason",
]
