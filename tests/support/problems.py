"""Hierarchies to test with: those of the bench of strictness."""

from lexstack_experiments.hierarchies.random_problems import (
    KINDS,
    near_singular,
    problem,
    side_by_side,
    truncated,
)

__all__ = ["KINDS", "near_singular", "problem", "side_by_side", "truncated"]
