"""The slow oracle for strict hierarchies, as tests use it."""

from lexstack.hqp import OracleLevel, lexicographic_oracle

__all__ = ["OracleLevel", "lexicographic_oracle"]
