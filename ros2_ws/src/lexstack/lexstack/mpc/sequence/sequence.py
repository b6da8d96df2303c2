"""Sequences of tasks: what is done when, and the window [l0, l0 + L - 1] that the MPC gets.

A sequence is a value: each event (time goes on, a release, a target that moves, an insertion, a
cancellation) makes a new one. It has no clock; every event brings the stamp and where the robot is.
Each time that the window changes, its trajectories are planned anew from the present pose.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc.sequence.robot_pose import RobotPose
from lexstack.mpc.sequence.task import Point, SequenceTask
from lexstack.mpc.sequence.trajectory import Trajectory
from lexstack.mpc.tracking_objectives import Moves, Objective
from lexstack.types import Vector


@dataclass(frozen=True, slots=True)
class Architecture:
    """How many tasks the MPC gets at a time, and whether arm and base work apart."""

    levels: int  # L
    decoupled: bool  # base tasks move the base alone, end-effector tasks the arm alone


HT_ARCH = Architecture(levels=2, decoupled=False)
"""Two tasks at a time, the whole robot for both."""
ST_ARCH = Architecture(levels=1, decoupled=True)
"""One task at a time, with arm and base apart."""


@dataclass(frozen=True, slots=True, eq=False)
class Sequence:
    """Tasks, how far they are done, and the trajectories of those in the window.

    Attributes:
        tasks: all of them, done ones too.
        architecture: which part of them is worked on together.
        first: l0, the place of the first task that is not done.
        trajectories: of the tasks in the window, highest first.
        within: since when the first task's error has been within its tolerance [s], or None.
        released: names of held tasks that may be done.
    """

    tasks: tuple[SequenceTask, ...]
    architecture: Architecture
    first: int = 0
    trajectories: tuple[Trajectory, ...] = ()
    within: float | None = None
    released: frozenset[str] = field(default_factory=frozenset)

    @classmethod
    def begin(
        cls, tasks: tuple[SequenceTask, ...], architecture: Architecture, pose: RobotPose
    ) -> Sequence:
        """Return the sequence at its start; raises InputError for no tasks or equal names."""
        check_tasks(tasks)
        return cls(tasks, architecture).replanned(pose)

    @property
    def done(self) -> bool:
        """Whether all tasks are; the last window is then held."""
        return self.first >= len(self.tasks)

    @property
    def window(self) -> tuple[SequenceTask, ...]:
        """The tasks l0 to l0 + L - 1; when all are done the last one."""
        first = min(self.first, len(self.tasks) - 1)
        return self.tasks[first : first + self.architecture.levels]

    @property
    def windows(self) -> tuple[tuple[SequenceTask, ...], ...]:
        """What the window will be, from now to the end."""
        last = max(len(self.tasks), self.first + 1)
        return tuple(replace(self, first=first).window for first in range(self.first, last))

    def errors(self, pose: RobotPose) -> tuple[float, float]:
        """Return distance [m] and angle [rad] from the goal of the first task in the window."""
        task = self.window[0]
        return pose.errors(task, np.array(task.points[-1]))

    def advanced(self, pose: RobotPose) -> Sequence:
        """Return the sequence after time has gone on; at most one task gets done at a time."""
        if self.done:
            return self
        task, stamp = self.window[0], pose.stamp
        distance, angle = self.errors(pose)
        arrived = stamp >= self.trajectories[0].end - 1e-9
        near = distance < task.tolerance and angle < task.tolerance_angle
        if not (arrived and near):
            return self if self.within is None else replace(self, within=None)
        since = stamp if self.within is None else self.within
        waits = task.held and task.name not in self.released
        if waits or stamp - since < task.dwell - 1e-9:
            return replace(self, within=since)
        return replace(self, first=self.first + 1, within=None).replanned(pose)

    def release(self, name: str) -> Sequence:
        """Return the sequence with a held task released; raises InputError for an unknown one."""
        self._place(name)
        return replace(self, released=self.released | {name})

    def retarget(self, name: str, points: tuple[Point, ...], pose: RobotPose) -> Sequence:
        """Return the sequence with a task's points moved; planned anew if it is in the window."""
        place = self._place(name)
        if place < self.first:
            raise InputError(f"sequence: task {name!r} is done: its target cannot move")
        moved = replace(self.tasks[place], points=points)
        tasks = (*self.tasks[:place], moved, *self.tasks[place + 1 :])
        result = replace(self, tasks=tasks)
        inside = place - self.first
        if inside >= len(self.trajectories):
            return result
        trajectories = list(self.trajectories)
        trajectories[inside] = moved.planned(pose)
        within = None if inside == 0 else self.within
        return replace(result, trajectories=tuple(trajectories), within=within)

    def insert(self, place: int, task: SequenceTask, pose: RobotPose) -> Sequence:
        """Return the sequence with one more task before the one at ``place`` (not yet done)."""
        if not self.first <= place <= len(self.tasks):
            raise InputError(
                f"sequence: place {place} to insert at: must be in "
                f"[{self.first}, {len(self.tasks)}]"
            )
        tasks = (*self.tasks[:place], task, *self.tasks[place:])
        check_tasks(tasks)
        return _changed(replace(self, tasks=tasks), place, pose)

    def cancel(self, name: str, pose: RobotPose) -> Sequence:
        """Return the sequence without a task that is not done.

        Raises:
            InputError: the task is unknown or done, or it is the only one.
        """
        place = self._place(name)
        if place < self.first:
            raise InputError(f"sequence: task {name!r} is done: it cannot be cancelled")
        tasks = (*self.tasks[:place], *self.tasks[place + 1 :])
        if not tasks:
            raise InputError(f"sequence: task {name!r} is the only one")
        return _changed(replace(self, tasks=tasks), place, pose)

    def objectives(self, times: Vector) -> tuple[Objective, ...]:
        """Return the levels of the MPC for the states 1 to N at these times [s], shape (N,)."""
        return tuple(
            Objective(
                task.name,
                task.kind,
                trajectory.at(times),
                self._moves(task),
                task.frame,
                task.joints,
            )
            for task, trajectory in zip(self.window, self.trajectories, strict=True)
        )

    def _moves(self, task: SequenceTask) -> Moves:
        """Return the joints that a task may use."""
        if not self.architecture.decoupled:
            return "all"
        return "base" if task.kind.startswith("base") else "arm"

    def replanned(self, pose: RobotPose) -> Sequence:
        """Return the sequence with all trajectories of its window from the present pose."""
        return replace(self, trajectories=tuple(task.planned(pose) for task in self.window))

    def _place(self, name: str) -> int:
        """Return a task's place; raises InputError for an unknown name."""
        for i, task in enumerate(self.tasks):
            if task.name == name:
                return i
        known = ", ".join(task.name for task in self.tasks)
        raise InputError(f"sequence: unknown task {name!r}; known: {known}")


def _changed(sequence: Sequence, place: int, pose: RobotPose) -> Sequence:
    """Return a sequence after a change at a place, planned anew if its window shows it."""
    if place >= sequence.first + sequence.architecture.levels:
        return sequence
    within = None if place == sequence.first else sequence.within
    return replace(sequence, within=within).replanned(pose)


def check_tasks(tasks: tuple[SequenceTask, ...]) -> None:
    """Raise InputError for no tasks, or two of one name."""
    if not tasks:
        raise InputError("sequence: at least one task is needed")
    names = [task.name for task in tasks]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"sequence: two tasks have the name {name!r}")
