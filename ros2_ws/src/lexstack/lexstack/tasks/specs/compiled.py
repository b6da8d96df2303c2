"""From a stack as a program writes it to what one team solves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.errors import ConfigurationError, LexstackError
from lexstack.robots import Team
from lexstack.tasks.frame_task import FrameTask
from lexstack.tasks.options import StackConfig
from lexstack.tasks.posture import Posture
from lexstack.tasks.registry import TASKS
from lexstack.tasks.specs.own import OwnTask, RowsTask
from lexstack.tasks.specs.spec import Targeted, TaskSpec
from lexstack.tasks.specs.stack import AnyTask, Stack
from lexstack.tasks.stack import Level, build_limits
from lexstack.tasks.stack import Stack as TeamStack
from lexstack.tasks.task import Task


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """A task with a target, on one robot.

    Attributes:
        spec: of the program; its target is what ``task`` follows.
        task: of the team.
        robot: its place in the team.
        frame: of the robot; empty: the task is on no frame.
        reference: the name under which references have the target of the frame.
    """

    spec: Targeted[Any]
    task: Task
    robot: int
    frame: str
    reference: str


@dataclass(frozen=True, slots=True, eq=False)
class Compiled:
    """A stack of one team, and its tasks with targets."""

    stack: TeamStack
    aims: tuple[Aim, ...]


class Names:
    """Names of task objects, each the same in all stacks of a team.

    Two tasks on one frame have targets of their own, so each has its own reference; and tasks of
    one kind on one frame are told apart by a number.
    """

    def __init__(self) -> None:
        """Start without any."""
        self._known: dict[tuple[int, str], tuple[AnyTask, str]] = {}
        self._count: dict[str, int] = {}

    def of(self, task: AnyTask, name: str) -> int:
        """Return how many other tasks had this name before a task got it."""
        key = id(task), name
        if key not in self._known:
            number = self._count.get(name, 0)
            self._count[name] = number + 1
            self._known[key] = task, str(number)  # the object is kept: its id stays its own
        return int(self._known[key][1])


def compiled(stack: Stack, team: Team, names: Names, name: str = "") -> Compiled:
    """Return what a team solves for a stack.

    Args:
        stack: of the program.
        team: the robots.
        names: of task objects in other stacks of this team.
        name: in place of the stack's own.

    Raises:
        ConfigurationError: the stack does not fit these robots; the text names the task.
    """
    called = name or stack.name or "stack"
    where = f"stack {called!r}"
    levels, aims = [], []
    for i, level in enumerate(stack.levels):
        tasks: list[Task] = []
        scales: list[float] = []
        for spec in level if isinstance(level, tuple) else ():
            for robot in _robots(spec, team, f"{where}: level {i + 1}: {spec.label}"):
                task = _made(spec, team, robot, f"{where}: level {i + 1}: {spec.label}")
                tasks.append(task)
                scales.append(float(np.sqrt(spec.weight)))
                aims += _named(spec, task, robot, names)
        levels.append(Level(tuple(tasks), tuple(scales)))
    config = StackConfig(called, "", (), limits={k: dict(v) for k, v in stack.limits.items()})
    limits = build_limits(config, team, where)
    everyone = tuple(range(len(team.robots)))
    return Compiled(TeamStack(called, tuple(levels), limits, everyone), tuple(aims))


def _robots(spec: AnyTask, team: Team, where: str) -> range | tuple[int]:
    """Return the places of the robots that a task is about."""
    if not spec.robot:
        return range(len(team.robots))
    try:
        return (team.index(spec.robot),)
    except ConfigurationError as error:
        raise ConfigurationError(f"{where}: {error}") from error


def _made(spec: AnyTask, team: Team, robot: int, where: str) -> Task:
    """Return a task of one robot."""
    if isinstance(spec, OwnTask):
        return RowsTask(team, robot, spec)
    try:
        return TASKS[spec.kind](team, robot, spec.parameters, where)
    except LexstackError as error:
        text = str(error)
        raise ConfigurationError(text if text.startswith(where) else f"{where}: {text}") from error


def _named(spec: AnyTask, task: Any, robot: int, names: Names) -> list[Aim]:
    """Give a task a name of its own, and return it with its target, if it has one."""
    number = names.of(spec, task.name)
    if number:
        task.name = f"{task.name}#{number + 1}"
    if not isinstance(spec, Targeted) or not isinstance(spec, TaskSpec):
        return []
    frame = spec.frame if isinstance(task, FrameTask) else ""  # type: ignore[attr-defined]
    reference = ""
    if isinstance(task, FrameTask):
        reference = f"{frame}#{names.of(spec, f'{robot} {frame}') + 1}"
        task.reference = reference
    elif isinstance(task, Posture):
        task.led = spec.revision > 0
    return [Aim(spec, task, robot, frame, reference)]
