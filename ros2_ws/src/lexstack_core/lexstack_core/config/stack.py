"""The schema of ``config/stacks/*.yaml``: one stack of tasks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from lexstack_core.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class TaskConfig:
    """One task of a level: its registered type, its robot, and that type's own parameters."""

    type: str  # a key of lexstack_core.tasks.TASKS
    robot: str = ""  # a robot's name; empty: one such task for every robot
    weight: float = 1.0  # of its squared residual within its level
    parameters: dict[str, Any] = field(default_factory=dict)  # checked by the task type

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a weight that is not positive."""
        if not 0.0 < self.weight < float("inf"):
            raise ConfigurationError(f"{where}: weight: must be finite and > 0, got {self.weight}")


@dataclass(frozen=True, slots=True)
class LevelConfig:
    """Tasks of equal priority."""

    tasks: tuple[TaskConfig, ...]

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a level without tasks."""
        if not self.tasks:
            raise ConfigurationError(f"{where}: tasks: a level needs at least one task")


@dataclass(frozen=True, slots=True)
class StackConfig:
    """Ordered levels, index 0 the highest priority."""

    name: str
    description: str
    levels: tuple[LevelConfig, ...]

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a stack without levels."""
        if not self.levels:
            raise ConfigurationError(f"{where}: levels: a stack needs at least one level")
