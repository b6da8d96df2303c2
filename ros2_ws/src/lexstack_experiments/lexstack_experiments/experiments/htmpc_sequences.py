"""Sequences of tasks of paper H, Sec. V-D, on the ideal plant: how they are run and measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.mpc import (
    HT_ARCH,
    ST_ARCH,
    Architecture,
    Htmpc,
    RobotPose,
    SequenceTask,
)
from lexstack.mpc import Sequence as TaskSequence
from lexstack.types import Matrix, Vector
from lexstack_experiments.baselines.htloop import Record, carry_out

ARCHITECTURES: dict[str, Architecture] = {"HT-Arch": HT_ARCH, "ST-Arch": ST_ARCH}
"""Two tasks at a time with the whole robot, and one at a time with arm and base apart."""

Event = Callable[[TaskSequence, RobotPose], TaskSequence]
"""What happens to a sequence at a state, before that state counts."""


@dataclass(frozen=True, slots=True, eq=False)
class Trip:
    """One sequence as it was carried out.

    Attributes:
        record: states, from rest to the end.
        done: when each task was done [s], by name, in their order.
        tool: positions of the tool, shape (m, 3), m.
        complete: whether every task was done.
    """

    record: Record
    done: dict[str, float]
    tool: Matrix
    complete: bool

    @property
    def seconds(self) -> float | None:
        """When the last task was done, None if one was not."""
        return list(self.done.values())[-1] if self.complete else None

    @property
    def path(self) -> Matrix:
        """Of the base, shape (m, 2), m."""
        return self.record.q[:, :2]

    @property
    def length(self) -> float:
        """Of the base's path [m]."""
        return length(self.path)

    @property
    def durations(self) -> dict[str, float]:
        """How long each task was the first one [s], by name."""
        ends = np.array([0.0, *self.done.values()])
        return dict(zip(self.done, np.diff(ends).tolist(), strict=True))

    def off(self, point: Vector) -> Vector:
        """Return the tool's distance from a point at every state, shape (m,), m."""
        return np.asarray(np.linalg.norm(self.tool - point, axis=1))

    def until(self, name: str) -> Matrix:
        """Return the path of the base up to when a task was done, shape (k, 2), m."""
        return self.path[self.record.times <= self.done[name] + 1e-9]


def travel(
    optimiser: Htmpc,
    home: Vector,
    tasks: tuple[SequenceTask, ...],
    architecture: Architecture,
    longest: float,
    event: Event = lambda sequence, _pose: sequence,
) -> Trip:
    """Carry out a sequence from rest at home, (n,), for at most ``longest`` seconds."""
    robot = optimiser.robot
    begin = TaskSequence.begin(tasks, architecture, RobotPose.of(robot, 0.0, home))
    record, done = carry_out(optimiser, home, begin, longest, event=event)
    tool = np.array([robot.tool(q)[0].position for q in record.q])
    return Trip(record, {name: time for time, name in done}, tool, len(done) == len(tasks))


def length(points: Matrix | Sequence[Vector]) -> float:
    """Return the length of a line through points of shape (m, 2) [m]."""
    return float(np.linalg.norm(np.diff(np.asarray(points), axis=0), axis=1).sum())
