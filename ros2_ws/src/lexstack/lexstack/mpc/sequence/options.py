"""What a sequence is built from: the tasks that the HTMPC executes on one robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lexstack.errors import ConfigurationError
from lexstack.options import finite, not_negative, positive

_MOST_ROUNDS = 100


@dataclass(frozen=True, slots=True)
class SequenceTaskConfig:
    """One task: where it leads, how fast, and when it is done."""

    name: str
    kind: Literal["ee_position", "ee_pose", "base_position", "base_pose"]
    points: tuple[tuple[float, ...], ...]  # m, rad, quaternion x y z w; world frame, the last: goal
    speed: float = 0.0  # m/s along straight lines; 0: the goal is the reference at once
    turn: float = 0.0  # rad/s at most; 0: no limit
    tolerance: float = 0.02  # m, done when its error is smaller
    tolerance_angle: float = 0.1  # rad
    dwell: float = 0.0  # s, for so long
    held: bool = False  # not done before it is released

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        not_negative(where, speed=self.speed, turn=self.turn, dwell=self.dwell)
        positive(where, tolerance=self.tolerance, tolerance_angle=self.tolerance_angle)
        for i, point in enumerate(self.points):
            finite(f"{where}: points[{i}]", value=point)


@dataclass(frozen=True, slots=True)
class SequenceConfig:
    """Tasks of one robot, in their order."""

    robot: str
    tasks: tuple[SequenceTaskConfig, ...]
    architecture: Literal["ht", "st"] = "ht"  # two tasks at a time, or arm and base apart
    rounds: int = 1  # how often all tasks are done; from the second on names end with #2, #3 ...

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for no tasks, or too many rounds."""
        if not self.tasks:
            raise ConfigurationError(f"{where}: tasks: at least one is needed")
        if not 1 <= self.rounds <= _MOST_ROUNDS:
            raise ConfigurationError(
                f"{where}: rounds: must be in [1, {_MOST_ROUNDS}], got {self.rounds}"
            )
