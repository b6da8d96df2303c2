"""Strict hierarchical quadratic programming: T(8) to T(15) behind one interface."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.hqp.backends.daqp import DaqpCascade
    from lexstack.hqp.backends.proxqp import ProxqpCascade
    from lexstack.hqp.cascade import NullSpaceCascade
    from lexstack.hqp.damping import Damped, Damper
    from lexstack.hqp.decoupled_solver import ClusteredSolver
    from lexstack.hqp.diagnosis import Blocked, Obstacle, describe, explain_unmet_levels
    from lexstack.hqp.fallback import FallbackSolver, rejection_reason
    from lexstack.hqp.hierarchy import Hierarchy, Signs
    from lexstack.hqp.kernel.solver import KernelSolver
    from lexstack.hqp.level_qp import LevelQp, QpBackend
    from lexstack.hqp.preconditions import active_bounds, starting_point
    from lexstack.hqp.problem import (
        DAMPED,
        NEAR,
        HqpProblem,
        HqpSolver,
        NearSingular,
        Solution,
        SolverFactory,
        Status,
        called,
        near_singularity,
    )
    from lexstack.hqp.solvers import DEFAULT_SOLVER, SOLVERS, make_solver, register_solver
else:
    __getattr__ = on_demand(
        __name__,
        {
            "backends.daqp": "DaqpCascade",
            "backends.proxqp": "ProxqpCascade",
            "cascade": "NullSpaceCascade",
            "damping": "Damped Damper",
            "decoupled_solver": "ClusteredSolver",
            "diagnosis": "Blocked Obstacle explain_unmet_levels describe",
            "fallback": "FallbackSolver rejection_reason",
            "hierarchy": "Hierarchy Signs",
            "kernel.solver": "KernelSolver",
            "level_qp": "LevelQp QpBackend",
            "preconditions": "active_bounds starting_point",
            "problem": "DAMPED NEAR HqpProblem HqpSolver NearSingular "
            "Solution SolverFactory Status called near_singularity",
            "solvers": "DEFAULT_SOLVER SOLVERS make_solver register_solver",
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
    "KernelSolver",
    "LevelQp",
    "NearSingular",
    "NullSpaceCascade",
    "Obstacle",
    "ProxqpCascade",
    "QpBackend",
    "Signs",
    "Solution",
    "SolverFactory",
    "Status",
    "active_bounds",
    "called",
    "describe",
    "explain_unmet_levels",
    "make_solver",
    "near_singularity",
    "register_solver",
    "rejection_reason",
    "starting_point",
]
