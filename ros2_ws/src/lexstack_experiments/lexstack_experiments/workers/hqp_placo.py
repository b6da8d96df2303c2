"""placo's QP, whose packages do not fit ours: the levels of a hierarchy as weighted tasks."""

from __future__ import annotations

from time import thread_time

import numpy as np
import placo
from serving import serve, uncollected


class Problems:
    """The problems of a sequence: for each, the rows of all levels, and the bounds."""

    def __init__(self) -> None:
        """Begin with none."""
        self._given: list[tuple[list[tuple[np.ndarray, np.ndarray]], np.ndarray, np.ndarray]] = []

    def load(self, problems: list[dict]) -> int:
        """Take problems: ``levels`` as pairs of matrix and target, ``lower``, ``upper``."""
        self._given = [
            (
                [(np.array(a), np.array(b)) for a, b in each["levels"]],
                np.array(each["lower"]),
                np.array(each["upper"]),
            )
            for each in problems
        ]
        return len(self._given)

    def solve(self) -> dict[str, list]:
        """Return chi, the time [s], and the reason of a failure for each problem."""
        return uncollected(self._solve)

    def _solve(self) -> dict[str, list]:
        """Solve all of them."""
        found: dict[str, list] = {"chi": [], "times": [], "reasons": []}
        for levels, lower, upper in self._given:
            begun = thread_time()
            try:
                chi, reason = weighted(levels, lower, upper), ""
            except RuntimeError as error:
                chi, reason = np.zeros(lower.size), str(error) or "no solution"
            found["times"].append(thread_time() - begun)
            found["chi"].append(chi.tolist())
            found["reasons"].append(reason)
        return found


def weighted(
    levels: list[tuple[np.ndarray, np.ndarray]], lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """Return chi with weights that fall by a hundred from level to level (costs by ten)."""
    problem = placo.Problem()
    x = problem.add_variable(lower.size)
    problem.add_constraint(x.expr() >= lower)
    problem.add_constraint(x.expr() <= upper)
    for k, (matrix, target) in enumerate(levels):
        problem.add_constraint(x.expr().left_multiply(matrix) == target).configure(
            "soft", 100.0**-k
        )
    problem.solve()
    return np.array(x.value)


if __name__ == "__main__":
    problems = Problems()
    serve({"load": problems.load, "solve": problems.solve})
