"""A stack of tasks as a value: levels in a strict order, changed by making another one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

from lexstack.errors import InputError
from lexstack.options import build
from lexstack.tasks.options import JointLimitConfig
from lexstack.tasks.specs.own import OwnTask
from lexstack.tasks.specs.spec import TaskSpec

AnyTask = TaskSpec | OwnTask
"""A task of the library, or one's own."""
Limits = Mapping[str, Mapping[str, JointLimitConfig]]
"""By robot, then by joint."""


@dataclass(frozen=True, eq=False)
class Stack:
    """Levels in a strict order: a level gets only the freedom that the levels above leave.

    A stack is a value. ``inserted``, ``removed``, ``swapped`` and ``limited`` return another one
    with the same task objects, to which a run can ``switch`` while it moves.

    Attributes:
        levels: the highest priority first; tasks of one level are weighed against each other.
        name: for people; empty: a run counts its stacks.
        limits: tighter limits of joints while the stack is in effect, by robot and joint.

    Raises:
        InputError: there is no level, an empty one, or a task twice.
    """

    levels: Sequence[Sequence[AnyTask] | AnyTask]
    name: str = ""
    limits: Limits = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the levels, and take a task for a level of its own."""
        where = f"stack {self.name!r}" if self.name else "stack"
        levels = tuple(
            (level,) if isinstance(level, AnyTask) else tuple(level) for level in self.levels
        )
        object.__setattr__(self, "levels", levels)
        object.__setattr__(self, "kept", {})
        if not levels or not all(levels):
            raise InputError(f"{where}: it needs at least one level, and a level at least one task")
        for i, level in enumerate(levels):
            for j, task in enumerate(level):
                if not isinstance(task, AnyTask):
                    got = type(task).__name__  # type: ignore[unreachable]  # callers err
                    raise InputError(f"{where}: levels[{i}][{j}]: expected a task, got {got}")
        tasks = list(self.tasks)
        for task in tasks:
            if sum(each is task for each in tasks) > 1:
                raise InputError(f"{where}: {task.label} stands in it twice")

    kept: dict[Any, Any] = field(init=False, repr=False)

    @property
    def tasks(self) -> Iterator[AnyTask]:
        """All tasks, the highest level first."""
        return (task for level in self.levels for task in _tuple(level))

    def inserted(self, at: int, *tasks: AnyTask) -> Stack:
        """Return the stack with a new level of these tasks before the level at place ``at``."""
        if not 0 <= at <= len(self.levels):
            raise InputError(f"stack: level {at} to insert at: must be in [0, {len(self.levels)}]")
        return replace(self, levels=(*self.levels[:at], tasks, *self.levels[at:]), name="")

    def added(self, at: int, task: AnyTask) -> Stack:
        """Return the stack with one more task in the level at place ``at``."""
        if not 0 <= at < len(self.levels):
            raise InputError(f"stack: level {at}: must be in [0, {len(self.levels) - 1}]")
        levels = [
            (*_tuple(level), task) if i == at else level for i, level in enumerate(self.levels)
        ]
        return replace(self, levels=levels, name="")

    def removed(self, task: AnyTask) -> Stack:
        """Return the stack without a task, and without its level if nothing else is in it."""
        self._check(task)
        levels = [tuple(each for each in _tuple(x) if each is not task) for x in self.levels]
        return replace(self, levels=[level for level in levels if level], name="")

    def replaced(self, task: AnyTask, by: AnyTask) -> Stack:
        """Return the stack with another task in the place of one."""
        self._check(task)
        levels = [
            tuple(by if each is task else each for each in _tuple(level)) for level in self.levels
        ]
        return replace(self, levels=levels, name="")

    def swapped(self, one: int, other: int) -> Stack:
        """Return the stack with two levels, given by their places, in each other's place."""
        levels = list(self.levels)
        for place in (one, other):
            if not 0 <= place < len(levels):
                raise InputError(f"stack: level {place}: must be in [0, {len(levels) - 1}]")
        levels[one], levels[other] = levels[other], levels[one]
        return replace(self, levels=levels, name="")

    def limited(
        self, limits: Mapping[str, Mapping[str, JointLimitConfig | Mapping[str, Any]]]
    ) -> Stack:
        """Return the stack with tighter limits of joints, beside those that it has.

        Args:
            limits: by robot, then by joint: a ``JointLimitConfig``, or its fields as a mapping.

        Raises:
            ConfigurationError: a field is unknown, or out of range.
        """
        return replace(self, limits=with_limits(self.limits, limits), name="")

    def _check(self, task: AnyTask) -> None:
        """Raise InputError for a task that is not in the stack."""
        if not any(each is task for each in self.tasks):
            known = ", ".join(each.label for each in self.tasks)
            raise InputError(f"stack: {task.label} is not in it; there is: {known}")


def with_limits(
    limits: Limits,
    more: Mapping[str, Mapping[str, JointLimitConfig | Mapping[str, Any]]],
    *,
    tightest: bool = False,
) -> dict[str, dict[str, JointLimitConfig]]:
    """Return limits with others beside them, by robot, joint and kind of limit.

    Args:
        limits: first ones.
        more: the others: values as ``JointLimitConfig``, or as its fields.
        tightest: whether the tighter one holds where both have one; else it is the other's.

    Raises:
        ConfigurationError: a field is unknown, or out of range.
    """
    merged = {robot: dict(joints) for robot, joints in limits.items()}
    for robot, joints in more.items():
        for joint, limit in joints.items():
            new = build(JointLimitConfig, limit, f"limits: {robot}: {joint}")
            before = merged.setdefault(robot, {}).get(joint, new)
            merged[robot][joint] = _merged(before, new, tightest=tightest)
    return merged


def _merged(before: JointLimitConfig, new: JointLimitConfig, *, tightest: bool) -> JointLimitConfig:
    """Return two limits of one joint as one."""
    kept: dict[str, Any] = {}
    for name in (each.name for each in fields(new)):
        old, value = getattr(before, name), getattr(new, name)
        if value is None or (tightest and old is None):
            kept[name] = old if value is None else value
        elif not tightest:
            kept[name] = value
        else:
            position = name == "position"
            kept[name] = (
                (max(old[0], value[0]), min(old[1], value[1])) if position else min(old, value)
            )
    return JointLimitConfig(**kept)


def _tuple(level: Sequence[AnyTask] | AnyTask) -> Sequence[AnyTask]:
    """Return a level as its tasks."""
    return (level,) if isinstance(level, AnyTask) else level
