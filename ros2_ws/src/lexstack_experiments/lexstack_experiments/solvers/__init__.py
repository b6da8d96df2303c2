"""An extension: the solvers that ours are compared with."""

from lexstack.hqp import register_solver
from lexstack_experiments.solvers.oracle import OracleLevel, OracleSolver, lexicographic_oracle
from lexstack_experiments.solvers.quadprog import QuadprogCascade

register_solver("quadprog", QuadprogCascade)
register_solver("oracle", OracleSolver)

__all__ = ["OracleLevel", "OracleSolver", "QuadprogCascade", "lexicographic_oracle"]
