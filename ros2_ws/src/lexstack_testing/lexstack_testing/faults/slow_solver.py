"""Robot B with a solver that takes FACTOR times as long, its first argument."""

from __future__ import annotations

import sys
import time
from typing import Any

from lexstack.control import StackSolver
from lexstack.hqp import Solution
from lexstack_ros.node.spin import run_node
from lexstack_ros.solver.node import StackSolverNode


class _Slow:
    """A stack solver that sleeps after its work."""

    def __init__(self, inner: StackSolver, factor: float) -> None:
        """Take ``factor`` times as long as ``inner``."""
        self._inner = inner
        self._factor = factor

    def __getattr__(self, name: str) -> Any:
        """Be the solver in all else."""
        return getattr(self._inner, name)

    def solve(self, *arguments: Any) -> Solution:
        """Solve, and wait."""
        begun = time.perf_counter()
        solution = self._inner.solve(*arguments)
        time.sleep((self._factor - 1.0) * (time.perf_counter() - begun))
        return solution


class SlowSolverNode(StackSolverNode):
    """The solver's node with such a solver."""

    def __init__(self, factor: float) -> None:
        """Build the usual node, and slow it down."""
        super().__init__()
        self._solver = _Slow(self._solver, factor)  # type: ignore[assignment]


def main() -> int:
    """Run it; returns the exit code."""
    factor = float(sys.argv.pop(1))
    return run_node(lambda: SlowSolverNode(factor))


if __name__ == "__main__":
    sys.exit(main())
