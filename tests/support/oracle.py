"""The slow oracle for strict hierarchies, as tests use it."""

from lexstack.hqp import lexicographic_oracle
from lexstack.hqp.backends.oracle import OracleLevel

__all__ = ["OracleLevel", "lexicographic_oracle"]
