"""The default HQP solver of a source tree, on problems that are sent to it."""

from __future__ import annotations

from time import thread_time
from typing import Any

import numpy as np
from layouts import first_of
from serving import serve, uncollected

Bounds = first_of("lexstack.limits:Bounds", "lexstack_core.bounds:Bounds")
HqpProblem = first_of("lexstack.hqp:HqpProblem", "lexstack_core.hqp:HqpProblem")
LinearTask = first_of("lexstack.types:LinearTask", "lexstack_core.linear:LinearTask")
make_solver = first_of("lexstack.hqp:make_solver", "lexstack_core.hqp:make_solver")


class Sequences:
    """Sequences of problems by name."""

    def __init__(self) -> None:
        """Begin with none."""
        self._given: dict[str, list[Any]] = {}

    def load(self, name: str, problems: list[dict[str, Any]]) -> int:
        """Take one: ``levels`` of rows (matrix, lower, upper), and ``lower`` and ``upper``."""
        self._given[name] = [
            HqpProblem(
                tuple(
                    (LinearTask(f"level_{k}", *(np.array(part, dtype=float) for part in rows)),)
                    for k, rows in enumerate(each["levels"])
                ),
                Bounds(np.array(each["lower"]), np.array(each["upper"])),
            )
            for each in problems
        ]
        return len(problems)

    def turn(self) -> dict[str, list[float]]:
        """Return the thread's processor time of every problem [us], warm from the one before."""
        return {name: uncollected(lambda p=given: timed(p)) for name, given in self._given.items()}


def timed(problems: list[Any]) -> list[float]:
    """Return the times of a sequence [us]."""
    solver, warm, times = make_solver(), None, []
    for problem in problems:
        begun = thread_time()
        warm = solver.solve(problem, warm)
        times.append(1e6 * (thread_time() - begun))
    return times


if __name__ == "__main__":
    sequences = Sequences()
    serve({"load": sequences.load, "turn": sequences.turn})
