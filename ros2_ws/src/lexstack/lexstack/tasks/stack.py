"""A stack of tasks: strictly ordered levels, built from a file for one team."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from lexstack.errors import ConfigurationError, ModelError
from lexstack.limits.joint_limits import LIMITS, JointLimits
from lexstack.options import shown, unknown
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.tasks.options import JointLimitConfig, StackConfig, TaskConfig
from lexstack.tasks.registry import TASKS
from lexstack.tasks.task import Task
from lexstack.types import Curve, LinearTask

AT_REST = " at rest"
"""Ends the name of a stack whose lower levels are minimum velocity."""


@dataclass(frozen=True, slots=True)
class Level:
    """Tasks of equal priority, each with the root of its weight."""

    tasks: tuple[Task, ...]
    scales: tuple[float, ...]

    def linearise(self, kinematics: Kinematics, references: References) -> tuple[LinearTask, ...]:
        """Return each task's rows, scaled by the root of its weight."""
        rows = [task.linearise(kinematics, references) for task in self.tasks]
        if self.weighted:
            rows = [_scaled(one, scale) for one, scale in zip(rows, self.scales, strict=True)]
        return tuple(rows)

    @property
    def weighted(self) -> bool:
        """Whether a weight is not 1."""
        return self.scales.count(1.0) != len(self.scales)

    def of(self, robots: Collection[int]) -> Level:
        """Return the tasks that move these robots alone."""
        kept = [i for i, task in enumerate(self.tasks) if set(task.robots) <= set(robots)]
        return Level(tuple(self.tasks[i] for i in kept), tuple(self.scales[i] for i in kept))


@dataclass(frozen=True, slots=True)
class Stack:
    """Ordered levels, index 0 the highest priority (SoT in T).

    Attributes:
        name: unique among the stacks.
        levels: highest first.
        limits: of all joints while this stack is in effect; None: the robots' own.
        robots: places in the team of the robots that it moves; None: all.
        planned: whether the controller follows the MPC's plan on it; its levels stand in for a lost
            one.
    """

    name: str
    levels: tuple[Level, ...]
    limits: JointLimits | None = None
    robots: tuple[int, ...] | None = None
    planned: bool = False

    def first(self, kinematics: Kinematics, references: References) -> tuple[LinearTask, ...]:
        """Return level 1 made linear, kept above the way to a source; none on a plan."""
        return () if self.planned else self.levels[0].linearise(kinematics, references)

    def linearise(
        self, kinematics: Kinematics, references: References
    ) -> tuple[tuple[LinearTask, ...], ...]:
        """Return all levels made linear at the present state, T(12)."""
        return tuple([level.linearise(kinematics, references) for level in self.levels])

    def of(self, robots: tuple[int, ...]) -> Stack:
        """Return the part of the stack that moves these robots; levels keep their rank."""
        if robots == self.robots:
            return self
        levels = tuple(level.of(robots) for level in self.levels)
        return Stack(self.name, levels, self.limits, robots, self.planned)

    def coupling(self, robots: Collection[int]) -> str:
        """Return the name of a task that moves both some of these robots and others, or ''."""
        return next(
            (
                task.name
                for level in self.levels
                for task in level.tasks
                if 0 < len(set(task.robots) & set(robots)) < len(set(task.robots))
            ),
            "",
        )


def joined(stacks: Sequence[Stack], team: Team | None = None) -> Stack:
    """Return stacks of different robots as one, level by level; of one stack itself.

    The limits stay those of each robot's stack. A plan is followed where all stacks follow one.

    Args:
        stacks: that share no robot.
        team: of all robots; needed where the stacks have different limits.

    Raises:
        ModelError: the limits differ, and there is no team to tell whose joints are whose.
    """
    if len(stacks) == 1:
        return stacks[0]
    depth = max(len(stack.levels) for stack in stacks)
    ranks = [[s.levels[k] for s in stacks if k < len(s.levels)] for k in range(depth)]
    levels = tuple(
        Level(
            tuple(task for level in rank for task in level.tasks),
            tuple(scale for level in rank for scale in level.scales),
        )
        for rank in ranks
    )
    name = " + ".join(dict.fromkeys(stack.name for stack in stacks))
    robots = sorted(robot for stack in stacks for robot in stack.robots or ())
    planned = all(stack.planned for stack in stacks)
    return Stack(name, levels, _joined_limits(stacks, team), tuple(robots), planned)


def _joined_limits(stacks: Sequence[Stack], team: Team | None) -> JointLimits | None:
    """Return the limits of every robot's stack on its joints; the same object where all share it.

    Limits are told apart by identity: a new object would let them come into force once more.
    """
    first = stacks[0].limits
    if all(stack.limits is first for stack in stacks):
        return first
    if team is None:
        names = ", ".join(repr(stack.name) for stack in stacks)
        raise ModelError(f"stacks {names}: they have different limits, and no team is given")
    return team.limits.replaced(
        (team.columns(stack.robots or ()), stack.limits)
        for stack in stacks
        if stack.limits is not None
    )


def build_stack(config: StackConfig, team: Team, where: str = "") -> Stack:
    """Return a configured stack for a team.

    Args:
        config: the stack.
        team: the robots.
        where: what names it in errors, its file; empty: by its name.

    Raises:
        ConfigurationError: it does not fit these robots; the text names the place.
    """
    where = where or f"stack {config.name}"
    levels = []
    robots = tuple(sorted(team.index(name) for name in config.robots or team.names))
    for i, level in enumerate(config.levels):
        tasks: list[Task] = []
        scales: list[float] = []
        for j, task in enumerate(level.tasks):
            built = _build_tasks(task, team, f"{where}: levels[{i}].tasks[{j}]", robots)
            tasks += built
            scales += [float(np.sqrt(task.weight))] * len(built)
        levels.append(Level(tuple(tasks), tuple(scales)))
    _check_names(where, levels)
    limits, planned = build_limits(config, team, where), config.source == "htmpc"
    return Stack(config.name, tuple(levels), limits, robots, planned)


def _build_tasks(config: TaskConfig, team: Team, where: str, everyone: Sequence[int]) -> list[Task]:
    """Return one task, or one for each robot of the stack where the file names none."""
    if config.type not in TASKS:
        raise ConfigurationError(f"{where}: type: {unknown('task', config.type, sorted(TASKS))}")
    robots = [team.index(config.robot)] if config.robot else everyone
    make = TASKS[config.type]
    return [make(team, robot, config.parameters, f"{where}: parameters") for robot in robots]


def build_limits(config: StackConfig, team: Team, where: str = "") -> JointLimits | None:
    """Return the limits of all joints under a stack, or None where its file has none.

    Args and errors are those of ``build_stack``.
    """
    if not config.limits:
        return None
    values = {name: getattr(team.limits, name).copy() for name in LIMITS}
    for robot, joints in config.limits.items():
        place = f"{where}: limits"
        _known(place, "robot", robot, team.names)
        number = team.index(robot)
        for joint, limit in joints.items():
            _known(f"{place}.{robot}", "joint", joint, team.robots[number].joints)
            i = team.slices[number].start + team.robots[number].joints.index(joint)
            if limit.position is not None and joint in team.robots[number].without_position:
                raise ConfigurationError(
                    f"{place}.{robot}.{joint}: position: a velocity of a differential base has none"
                )
            for name, value in _given(limit).items():
                _check_within(f"{place}.{robot}.{joint}", name, value, values[name][i])
                values[name][i] = value
    return JointLimits(**values)


def _given(limit: JointLimitConfig) -> dict[str, float]:
    """Return the limits that a file gives for a joint, by their names in ``JointLimits``."""
    lower, upper = limit.position or (None, None)
    values = {"position_lower": lower, "position_upper": upper}
    values |= {name: getattr(limit, name) for name in ("velocity", "acceleration", "jerk")}
    return {name: value for name, value in values.items() if value is not None}


def _check_within(where: str, name: str, value: float, own: float) -> None:
    """Raise ConfigurationError for a limit that is wider than the robot's own."""
    wider = value < own if name == "position_lower" else value > own
    if wider:
        raise ConfigurationError(f"{where}: {name}: {value} is beyond the robot's own {own}")


def _known(where: str, kind: str, name: str, known: tuple[str, ...]) -> None:
    """Raise ConfigurationError unless ``name`` is one of the known."""
    if name not in known:
        listed = ", ".join(known)
        raise ConfigurationError(f"{where}: unknown {kind} {shown(name)}; known: {listed}")


def _check_names(where: str, levels: list[Level]) -> None:
    """Raise ConfigurationError where a task stands twice in a stack."""
    names = [task.name for level in levels for task in level.tasks]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ConfigurationError(f"{where}: task {twice!r} stands in it twice")


def _scaled(task: LinearTask, scale: float) -> LinearTask:
    """Return the task with its rows multiplied by ``scale``."""
    if scale == 1.0:
        return task
    rows = (scale * task.matrix, scale * task.lower, scale * task.upper)
    curve = task.curve and _scaled_curve(task.curve, scale)
    feed = None if task.feed is None else scale * task.feed
    return LinearTask(task.name, *rows, curve, feed, task.frame)


@lru_cache(maxsize=256)
def _scaled_curve(curve: Curve, scale: float) -> Curve:
    """Return the curve of scaled rows: the same object at every tick, as curves are compared."""
    return replace(curve, scale=scale)
