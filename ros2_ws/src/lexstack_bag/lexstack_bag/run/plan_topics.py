"""Collects what the HTMPC sent: plans, progress and sequences, robot by robot."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc import COLUMNS, SequenceTask
from lexstack.robots import TOOL
from lexstack_bag.errors import BagError
from lexstack_bag.run.columns import StreamBuilder, seconds
from lexstack_bag.run.run import PlanStream, PlanTopics, ProgressStream, SequenceEvent
from lexstack_bag.topics import PLAN, PROGRESS, SEQUENCE


class PlanBuilder:
    """Takes the plans of one robot."""

    def __init__(self, rate: float) -> None:
        """Know no joints before the first plan; ``rate`` in ticks per second."""
        self._rate = rate
        self._plans: StreamBuilder[PlanStream] | None = None

    def add(self, message: Any, sent: int) -> None:
        """Append a plan that was sent at a time [ns]; one of another size becomes nan."""
        velocity = np.concatenate([point.velocities for point in message.points])
        if self._plans is None:
            self._plans = StreamBuilder(PlanStream, velocity.size, "all")
        row = SimpleNamespace(
            tick=round(seconds(message.header.stamp) * self._rate),
            header=message.header,
            times=[seconds(point.time_from_start) for point in message.points],
            velocity=velocity,
        )
        self._plans.add(row, sent)

    def build(self) -> PlanStream:
        """Return the stream."""
        return (self._plans or StreamBuilder(PlanStream, 1, "all")).build()


@dataclass
class _Robot:
    """What is collected of one robot."""

    plans: PlanBuilder
    progress: StreamBuilder[ProgressStream]
    events: list[SequenceEvent]

    @classmethod
    def new(cls, rate: float) -> _Robot:
        """Return one of which nothing is known."""
        return cls(PlanBuilder(rate), StreamBuilder(ProgressStream, 1, "all"), [])


class PlanTopicsCollector:
    """Takes the messages of the HTMPC."""

    def __init__(self, robots: Collection[str], rate: float, *, plans: bool) -> None:
        """Start empty for the robots of a scenario; ``rate`` in ticks per second.

        Without ``plans`` these stay empty: they are large, and only a replay needs them.
        """
        self._names = tuple(robots)
        self._wanted = (PLAN, PROGRESS, SEQUENCE) if plans else (PROGRESS, SEQUENCE)
        self._rate = rate
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget all: the plant was reset."""
        self._robots: dict[str, _Robot] = {}

    def add(self, topic: str, decode: Callable[[], Any], sent: int) -> bool:
        """Take a message that was sent at a time [ns]; return whether it is the HTMPC's.

        Raises:
            BagError: a sequence holds what no sequence can hold.
        """
        if topic not in self._wanted:
            return topic == PLAN
        message = decode()
        plan = topic == PLAN
        name = next(iter(message.joint_names), "").partition("/")[0] if plan else message.robot
        if name not in self._names or (plan and not message.points):
            return True  # the controller refuses it
        robot = self._robots.setdefault(name, _Robot.new(self._rate))
        if plan:
            robot.plans.add(message, sent)
        elif topic == PROGRESS:
            robot.progress.add(message, sent)
        else:
            robot.events.append(_event(message, sent))
        return True

    def build(self) -> dict[str, PlanTopics]:
        """Return what was collected, by robot in the order of the scenario."""
        return {
            name: PlanTopics(
                self._robots[name].plans.build(),
                self._robots[name].progress.build(),
                tuple(sorted(self._robots[name].events, key=lambda event: event.sent)),
            )
            for name in self._names
            if name in self._robots
        }


def _event(message: Any, sent: int) -> SequenceEvent:
    """Return a message as an event."""
    try:
        tasks = _tasks(message)
    except (InputError, KeyError, IndexError) as error:
        raise BagError(f"{SEQUENCE}: a message at tick {message.tick}: {error}") from error
    return SequenceEvent(
        sent, int(message.tick), message.architecture, message.event, message.changed, tasks
    )


def _tasks(message: Any) -> tuple[SequenceTask, ...]:
    """Return the tasks with the very numbers that the MPC had."""
    numbers = [float(value) for value in message.coordinates]
    tasks = []
    for task in message.tasks:
        # Bags from before tasks had frames and joints know neither.
        frame, joints = getattr(task, "frame", ""), tuple(getattr(task, "joints", ()))
        columns = COLUMNS[task.kind] or len(task.positions) // len(task.points)
        points = []
        for _ in task.points:
            points.append(tuple(numbers[:columns]))
            del numbers[:columns]
        tasks.append(
            SequenceTask(
                task.name,
                task.kind,
                tuple(points),
                float(task.speed) or None,
                float(task.turn) or None,
                float(task.tolerance),
                float(task.tolerance_angle),
                float(task.dwell),
                bool(task.held),
                frame or TOOL,
                joints,
            )
        )
    return tuple(tasks)
