"""What robot A follows where robot B is lost."""

from __future__ import annotations

from typing import Protocol

from lexstack_core.linear import Vector
from lexstack_core.model import Kinematics
from lexstack_core.references import References
from lexstack_core.stack import Stack


class LocalSource(Protocol):
    """A's own stand-in for robot B."""

    def chi(self, stack: str, kinematics: Kinematics, references: References) -> Vector:
        """Return the optimum of a stack, shape (n,), or zeros where it cannot be solved."""
        ...

    def at_rest(self, stack: str) -> Stack:
        """Return level 1 of a stack with minimum velocity below it."""
        ...
