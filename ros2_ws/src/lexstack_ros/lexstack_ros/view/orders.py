"""What the page may ask for: values of a browser, every one checked."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from lexstack.errors import InputError
from lexstack.references import TOOL
from lexstack_config.sent_stacks import LARGEST

_FARTHEST = 100.0  # m
_LONGEST = 60.0  # s
_STRONGEST = 1000.0  # N
_UNIT = 1e-3  # how far the norm of a quaternion may be from 1
LINKS = ("base", "tool")
"""What may be pushed."""


@dataclass(frozen=True, slots=True)
class Switch:
    """Switch to a stack; duration [s], 0: from the configuration."""

    stack: str
    duration: float


@dataclass(frozen=True, slots=True)
class SwitchToText:
    """Switch to the stack in a text of YAML; duration [s] as in ``Switch``."""

    text: str
    duration: float


@dataclass(frozen=True, slots=True)
class Cancel:
    """Go back from the transition that is under way."""


@dataclass(frozen=True, slots=True)
class ToolTarget:
    """A new goal of a tool or another frame: position [m], quaternion x, y, z, w, world."""

    robot: str
    position: tuple[float, ...]
    quaternion: tuple[float, ...]
    frame: str = TOOL


@dataclass(frozen=True, slots=True)
class BaseTarget:
    """A new goal of a base: x [m], y [m], yaw [rad], world."""

    robot: str
    place: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Push:
    """A force [N] in the world frame on a link for a duration [s] of simulated time."""

    robot: str
    link: str  # of LINKS
    force: tuple[float, ...]
    duration: float


@dataclass(frozen=True, slots=True)
class Pause:
    """Let the plant stand still after the present tick, or go on."""

    paused: bool


@dataclass(frozen=True, slots=True)
class Step:
    """One tick of a plant that stands still."""


@dataclass(frozen=True, slots=True)
class Reset:
    """Back to the start of the scenario."""


@dataclass(frozen=True, slots=True)
class Enable:
    """Let a robot follow commands, or not."""

    robot: str
    enabled: bool


@dataclass(frozen=True, slots=True)
class Execute:
    """Begin a sequence of the scenario."""

    sequence: str


@dataclass(frozen=True, slots=True)
class Stop:
    """Cancel the sequence that the page has begun last."""


@dataclass(frozen=True, slots=True)
class Release:
    """Release the held tasks of the sequences under way."""


Order = (
    Switch | SwitchToText | Cancel | ToolTarget | BaseTarget | Push | Pause | Step | Reset | Enable
    | Execute | Stop | Release
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Known:
    """What orders may name."""

    robots: Collection[str]
    stacks: Collection[str]
    sequences: Collection[str] = ()

    def switch(self, stack: Any, duration: Any) -> Switch:
        """Return the order; raises InputError, as all of these."""
        return Switch(
            one_of(stack, "stack", self.stacks), number(duration, "duration", 0.0, _LONGEST)
        )

    def switch_to_text(self, text: Any, duration: Any) -> SwitchToText:
        """Return the order; what is in the text, the controller checks."""
        if not isinstance(text, str) or not text.strip():
            raise InputError("stack as text: it is empty")
        size = len(text.encode("utf-8", "surrogatepass"))
        if size > LARGEST:
            raise InputError(f"stack as text: {size} bytes, at most {LARGEST}")
        return SwitchToText(text, number(duration, "duration", 0.0, _LONGEST))

    def tool_target(
        self, robot: Any, position: Any, quaternion: Any, frame: str = TOOL
    ) -> ToolTarget:
        """Return the order; the quaternion is x, y, z, w."""
        turn = numbers(quaternion, "orientation", 4, 1.0 + _UNIT)
        if abs(math.hypot(*turn) - 1.0) > _UNIT:
            raise InputError(f"orientation: norm must be 1, got {math.hypot(*turn):.4f}")
        place = numbers(position, "position", 3, _FARTHEST)
        return ToolTarget(one_of(robot, "robot", self.robots), place, turn, frame)

    def base_target(self, robot: Any, place: Any) -> BaseTarget:
        """Return the order; the place is x, y, yaw."""
        return BaseTarget(
            one_of(robot, "robot", self.robots), numbers(place, "place", 3, _FARTHEST)
        )

    def push(self, robot: Any, link: Any, force: Any, duration: Any) -> Push:
        """Return the order."""
        return Push(
            one_of(robot, "robot", self.robots),
            one_of(link, "link", LINKS),
            numbers(force, "force", 3, _STRONGEST),
            number(duration, "duration", 0.001, _LONGEST),
        )

    def enable(self, robot: Any, enabled: Any) -> Enable:
        """Return the order."""
        return Enable(one_of(robot, "robot", self.robots), bool(enabled))

    def execute(self, sequence: Any) -> Execute:
        """Return the order."""
        return Execute(one_of(sequence, "sequence", self.sequences))


def one_of(value: Any, what: str, known: Collection[str]) -> str:
    """Return one of the known words; raises InputError, as those below."""
    if not isinstance(value, str) or value not in known:
        raise InputError(f"{what}: expected one of {', '.join(known)}, got {value!r:.80}")
    return value


def number(value: Any, what: str, lower: float, upper: float) -> float:
    """Return a number within limits."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{what}: expected a number, got {value!r:.80}")
    if not lower <= value <= upper:
        raise InputError(f"{what}: must be from {lower:g} to {upper:g}, got {value:g}")
    return float(value)


def numbers(values: Any, what: str, count: int, most: float) -> tuple[float, ...]:
    """Return ``count`` numbers of at most ``most``."""
    if hasattr(values, "tolist"):
        values = values.tolist()
    if not isinstance(values, Sequence) or isinstance(values, str) or len(values) != count:
        raise InputError(f"{what}: expected {count} numbers, got {values!r:.80}")
    return tuple(number(value, f"{what}[{i}]", -most, most) for i, value in enumerate(values))
