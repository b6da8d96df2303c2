"""The slow oracle for strict hierarchies, as tests use it."""

from lexstack_core.hqp.oracle import OracleLevel, lexicographic_oracle

__all__ = ["OracleLevel", "lexicographic_oracle"]
