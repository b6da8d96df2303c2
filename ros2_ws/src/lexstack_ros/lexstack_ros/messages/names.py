"""The names of nodes and topics.

Every topic, service and action has a relative name. Without a namespace it is what documents and
bags call it, /plant/state; with ``-r __ns:=/cell1`` it is /cell1/plant/state, of a second cell.
"""

from __future__ import annotations

import re

SOLVER = "stack_solver"  # the solver; further ones are stack_solver_2 and so on
PAGE = "view"
URL = "page: "  # what stands before the live page's address in what its process prints
FOXGLOVE = "foxglove: "  # the same of the address for Foxglove


def relative(name: str) -> str:
    """Return a name as a node has to give it, so that it lies in the node's namespace."""
    return name.removeprefix("/")


def base_of(node: str) -> str:
    """Return the name of a node without its number: stack_solver_2 is a stack_solver."""
    return SOLVER if re.fullmatch(rf"{SOLVER}_[1-9][0-9]?", node) else node
