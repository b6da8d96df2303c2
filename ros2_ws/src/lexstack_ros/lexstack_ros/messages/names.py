"""The names of nodes."""

from __future__ import annotations

import re

SOLVER = "stack_solver"  # the solver; further ones are stack_solver_2 and so on
PAGE = "view"
URL = "page: "  # what stands before the live page's address in what its process prints


def base_of(node: str) -> str:
    """Return the name of a node without its number: stack_solver_2 is a stack_solver."""
    return SOLVER if re.fullmatch(rf"{SOLVER}_[1-9][0-9]?", node) else node
