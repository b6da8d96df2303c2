"""What all tasks of a program share: checked fields, a robot, a weight, and a target."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from lexstack.options import Positive, build

G = TypeVar("G")


@dataclass(frozen=True, eq=False, kw_only=True)
class TaskSpec:
    """A task as a program writes it: a value, but for the target that it may be given.

    Its fields are those of the section ``parameters`` in a stack file, and are checked in the same
    way. One object may stand in several stacks and run on several teams.

    Attributes:
        kind: the type by which stack files name it.
        robot: name of the robot that it is about; empty: one such task for every robot.
        weight: of its squared residual within its level.

    Raises:
        ConfigurationError: a value is out of range; the text names task and field.
    """

    kind: ClassVar[str] = ""

    robot: str = ""
    weight: Positive = 1.0

    # Two tasks with the same fields are two tasks: each has a target of its own.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __post_init__(self) -> None:
        """Check the fields, and take arrays and lists for tuples."""
        where, kind = type(self).__name__, self._fields()
        given = {f.name: _plain(getattr(self, f.name)) for f in dataclasses.fields(kind)}
        checked = build(kind, given, where)
        for name in given:
            object.__setattr__(self, name, getattr(checked, name))
        common = build(_Common, {"robot": self.robot, "weight": _plain(self.weight)}, where)
        object.__setattr__(self, "weight", common.weight)

    @classmethod
    def _fields(cls) -> type[Any]:
        """Return the dataclass of the parameters, which the stack file's section is too."""
        return next(base for base in cls.__mro__ if dataclasses.is_dataclass(base) and _is(base))

    @property
    def parameters(self) -> dict[str, Any]:
        """The section ``parameters`` of a stack file."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(self._fields())}

    @property
    def label(self) -> str:
        """What errors call it: the class, and the frame where it has one."""
        frame = getattr(self, "frame", "")
        return type(self).__name__ + (f"({frame!r})" if frame else "")


@dataclass(frozen=True)
class _Common:
    """The fields that every task has."""

    robot: str
    weight: Positive


def _is(kind: type) -> bool:
    """Return whether a class has parameters of a stack file and nothing else."""
    return not issubclass(kind, TaskSpec)


def _plain(value: Any) -> Any:
    """Return arrays and numbers of numpy as Python's."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


class Targeted(Generic[G]):
    """A task that leads somewhere: the target stays with the object, in every stack it is in."""

    def set_target(self, target: G) -> None:
        """Lead to another target from the next tick on.

        Args:
            target: a value, or a trajectory over simulated time; the class says which.

        Raises:
            InputError: the target has another form, or a number that is not finite.
        """
        object.__setattr__(self, "_target", self._checked(target))
        object.__setattr__(self, "_revision", self.revision + 1)

    @property
    def goal(self) -> Any:
        """The target as it was understood; None: none was given yet."""
        return getattr(self, "_target", None)

    @property
    def revision(self) -> int:
        """How often a target was given."""
        return int(getattr(self, "_revision", 0))

    def _checked(self, target: Any) -> Any:
        """Return a target in the form that references have."""
        raise NotImplementedError
