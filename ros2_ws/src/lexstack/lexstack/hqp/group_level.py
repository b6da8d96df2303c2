"""One level of a hierarchy, as far as it concerns robots that are coupled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from lexstack.types import LinearTask, Matrix, Vector

_FULL = 1e-6  # squared, of a saturated error that is no longer told from the limit


@dataclass(slots=True)
class GroupLevel:
    """One level, as far as it concerns robots that are coupled.

    Attributes:
        tasks: with rows on these robots.
        matrix: the equality rows, shape (m, r).
        error: e of each row, 0 where a row asks for something else, shape (m,).
        scale: the largest root of a weight among the tasks.
        curved: whether a task of it is curved.
        nested: whether a level above is.
        starts: the first row of each task.
    """

    tasks: tuple[LinearTask, ...]
    matrix: Matrix
    error: Vector
    scale: float
    curved: bool
    nested: bool
    starts: tuple[int, ...]

    @property
    def partial(self) -> bool:
        """Whether the rows of some task are a part of a Jacobian, or in other axes."""
        return any(task.frame is not None for task in self.tasks)

    def unsaturated(self) -> Vector:
        """Return the error before the tasks saturated it, shape (m,)."""
        error = self.error.copy()
        for here, longest in self._together():
            part = error[here] / longest
            error[here] /= math.sqrt(max(_FULL, 1.0 - float(part.dot(part))))
        return error

    def saturated(self, error: Vector) -> Vector:
        """Return an error, shape (m,), as the tasks would saturate it."""
        result = error.copy()
        for here, longest in self._together():
            part = error[here] / longest
            result[here] /= math.sqrt(1.0 + float(part.dot(part)))
        return result

    def _together(self) -> Iterator[tuple[slice, float]]:
        """Yield rows whose error was saturated together, and the length that it stays below."""
        for task, start in zip(self.tasks, self.starts, strict=True):
            if task.curve is not None:
                sizes = task.curve.sizes or (3,) * len(task.curve.limits)
                first = start
                for size, limit in zip(sizes, task.curve.limits, strict=True):
                    longest = limit * task.curve.scale / task.curve.gain
                    yield slice(first, first + size), longest
                    first += size
