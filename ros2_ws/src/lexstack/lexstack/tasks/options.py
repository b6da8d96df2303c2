"""What a stack is built from: its levels, their tasks, and limits while it is in effect."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from lexstack.errors import ConfigurationError
from lexstack.options import OLD_NAMES, NotEmpty, Positive


@dataclass(frozen=True, slots=True)
class TaskConfig:
    """One task of a level: its registered type, its robot, and that type's own parameters."""

    type: str  # a key of lexstack.tasks.TASKS
    robot: str = ""  # a robot's name; empty: one such task for every robot
    weight: Positive = 1.0  # of its squared residual within its level
    parameters: dict[str, Any] = field(default_factory=dict)  # checked by the task type

    def __post_init__(self) -> None:
        """Take an old name of a type for the new one."""
        object.__setattr__(self, "type", OLD_NAMES["TaskConfig.type"].get(self.type, self.type))


@dataclass(frozen=True, slots=True)
class LevelConfig:
    """Tasks of equal priority."""

    # that share the priority
    tasks: Annotated[tuple[TaskConfig, ...], NotEmpty("a level needs at least one task")]


@dataclass(frozen=True, slots=True)
class JointLimitConfig:
    """Tighter limits of one joint; what is not given stays as the robot has it."""

    position: tuple[float, float] | None = None  # rad (bases: m, m, rad): lower, upper
    velocity: Positive | None = None  # rad/s (bases: m/s, m/s, rad/s)
    acceleration: Positive | None = None  # rad/s2 (bases: m/s2, m/s2, rad/s2)
    jerk: Positive | None = None  # rad/s3 (bases: m/s3, m/s3, rad/s3)

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for an empty range, or where no limit is given."""
        if self.position is not None and not self.position[0] < self.position[1]:
            lower, upper = self.position
            raise ConfigurationError(f"{where}: position: lower {lower} is not below upper {upper}")
        if self == JointLimitConfig():
            raise ConfigurationError(f"{where}: no limit is given")


@dataclass(frozen=True, slots=True)
class StackConfig:
    """Ordered levels, index 0 the highest priority, and the limits while they are in effect."""

    name: str  # of its file
    description: str  # in a sentence
    # the highest priority first
    levels: Annotated[tuple[LevelConfig, ...], NotEmpty("a stack needs at least one level")]
    robots: tuple[str, ...] = ()  # that it moves; empty: all of the team
    # Who solves it in a transition. htmpc: the controller follows the MPC's plan for as long as it
    # is on this stack, and serves its levels where the plan is lost.
    source: Literal["robot_b", "htmpc"] = "robot_b"
    limits: dict[str, dict[str, JointLimitConfig]] = field(default_factory=dict)  # robot, joint

    @classmethod
    def of_tasks(cls, name: str, *types: str) -> StackConfig:
        """Return a stack of one task a level, highest first: for every robot, as by default.

        Args:
            name: of the stack.
            types: keys of ``lexstack.tasks.TASKS``.
        """
        levels = tuple(LevelConfig((TaskConfig(kind),)) for kind in types)
        return cls(name, "", levels)

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a stack that contradicts itself."""
        for name in self.robots:
            if self.robots.count(name) > 1:
                raise ConfigurationError(f"{where}: robots: {name!r} stands in it twice")
        for name in self.named if self.robots else ():
            if name not in self.robots:
                known = ", ".join(self.robots)
                raise ConfigurationError(
                    f"{where}: robots: {name!r} is named by a task or limit, but not here: {known}"
                )

    @property
    def named(self) -> tuple[str, ...]:
        """The robots that the stack names: in ``robots``, in its tasks and in its limits."""
        tasks = [task for level in self.levels for task in level.tasks]
        names = [*self.robots, *self.limits]
        for task in tasks:
            # Tasks that couple robots name the others in their parameters.
            others = task.parameters.get("robots") or ()
            names += [task.robot, str(task.parameters.get("other", "")), *map(str, others)]
        return tuple(dict.fromkeys(name for name in names if name))


def plan_stack(robot: str) -> str:
    """Return the name of the stack on which a robot follows the HTMPC's plan."""
    return f"plan_{robot}"
