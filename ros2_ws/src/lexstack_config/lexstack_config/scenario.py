"""The schema of ``config/scenarios/*.yaml``: robots, timing, and what happens when."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

import lexstack.robots
from lexstack.errors import ConfigurationError
from lexstack.mpc import SequenceConfig
from lexstack.options import (
    Finite,
    Finite3,
    Name,
    NotEmpty,
    NotNegative,
    Pattern,
    Positive,
    Range,
    RosName,
    shown,
)
from lexstack.robots import ObstacleConfig, Vector3
from lexstack.transition import TransitionConfig
from lexstack_config.plant import PlantConfig
from lexstack_config.reference_topics import ReferenceTopicsConfig
from lexstack_config.stream import StreamConfig
from lexstack_config.trajectories import (
    PathConfig,
    PostureWayConfig,
    Quaternion,
    TwistEventConfig,
    WayConfig,
)

if TYPE_CHECKING:
    from lexstack.robots import Pose

_Module = Annotated[
    str,
    Pattern(
        r"[A-Za-z_]\w{0,63}(\.[A-Za-z_]\w{0,63}){0,9}",
        "a module has a Python name, with dots between its parts",
    ),
]
Mode = Literal["lockstep", "realtime"]
_FASTEST = 1000.0  # Hz, the plant's own steps
_LONGEST = 1e6  # s, 11 days


@dataclass(frozen=True, slots=True)
class PlacementConfig:
    """One robot of the scenario: its kind, and where its base starts, or is mounted."""

    model: Name  # a name of config/robots
    base: Finite3 = (0.0, 0.0, 0.0)  # x [m], y [m], yaw [rad] in the world frame
    z: Finite = 0.0  # m, height of the mounting of a robot without a base

    @property
    def mounting(self) -> tuple[float, float, float, float]:
        """Where a robot without a base stands in the world: x, y, z [m], yaw [rad]."""
        x, y, yaw = self.base
        return x, y, self.z, yaw


@dataclass(frozen=True, slots=True)
class PoseConfig:
    """A pose in the world frame."""

    position: Finite3  # m
    orientation: Quaternion  # x, y, z, w

    def validate(self, where: str) -> None:
        """Raise ConfigurationError unless the quaternion has unit length."""
        norm = sum(value * value for value in self.orientation) ** 0.5
        if abs(norm - 1.0) > 1e-3:
            raise ConfigurationError(f"{where}: orientation: norm must be 1, got {norm:.4f}")


@dataclass(frozen=True, slots=True)
class TimeoutsConfig:
    """Every wait has an end."""

    source_wall: Positive = (
        1.0  # s of wall time in which the solver's chi of a tick must come (lockstep)
    )
    source_stale: Positive = (
        0.05  # s of simulated time after which the solver's chi is stale (realtime)
    )
    source_patience: Positive = (
        0.5  # s of simulated time in which the solver's first chi must come (realtime)
    )
    plan_stale: Positive = 0.25  # s of simulated time after which a plan is stale (realtime)
    command_wall: Positive = 2.0  # s of wall time that the bridge waits for a command (lockstep)
    watchdog: Positive = 0.1  # s of simulated time without a command after which all joints brake
    target_horizon: Positive = 60.0  # s of simulated time that a target's stamp may be ahead


@dataclass(frozen=True, slots=True)
class HtmpcRunConfig:
    """How the HTMPC runs beside the controllers."""

    parameters: str = "lexstack"  # a file of config/htmpc
    rate: Positive = 20.0  # Hz, plans per simulated second; rounded to whole ticks
    always: bool = False  # whether its node runs also where the scenario has no sequences

    def ticks(self, rate: float) -> int:
        """Return the ticks from plan to plan, given the ticks per second."""
        return max(1, round(rate / self.rate))


@dataclass(frozen=True, slots=True)
class SequenceChangeConfig:
    """A change of a sequence that is being executed."""

    robot: str  # its name in the scenario
    change: Literal["release", "retarget", "cancel"]  # what happens to the task
    task: str  # its name
    points: tuple[tuple[float, ...], ...] = ()  # retarget: where it leads now


@dataclass(frozen=True, slots=True)
class EventConfig:
    """What happens at one time: new references, and perhaps a switch of the stack."""

    at: NotNegative  # s, simulated
    switch: str = ""  # the stack to switch to; empty: none
    duration: NotNegative = 0.0  # s of the transition; 0: from the scenario's transition
    robots: tuple[str, ...] = ()  # that switch; empty: all that the stack moves
    ee_target: dict[str, PoseConfig] = field(default_factory=dict)  # by robot
    # by robot: x [m], y [m], yaw [rad]
    base_target: dict[str, Vector3] = field(default_factory=dict)
    ee_trajectory: dict[str, WayConfig] = field(default_factory=dict)  # by robot
    ee_twist: dict[str, TwistEventConfig] = field(default_factory=dict)  # by robot
    base_path: dict[str, PathConfig] = field(default_factory=dict)  # by robot
    posture_trajectory: dict[str, PostureWayConfig] = field(default_factory=dict)  # by robot
    execute: tuple[str, ...] = ()  # names of sequences that begin
    changes: tuple[SequenceChangeConfig, ...] = ()  # of sequences that are under way


TARGETS = (
    *("ee_target", "base_target", "ee_trajectory", "ee_twist", "base_path", "posture_trajectory"),
)
"""Keys of an event that set references, by robot."""


@dataclass(frozen=True, slots=True)
class ScenarioConfig:
    """A whole run."""

    name: Name  # of the run
    description: str  # in a sentence
    robots: Annotated[  # in the order of chi
        dict[RosName, PlacementConfig], NotEmpty("at least one robot is needed")
    ]
    rate: Annotated[Positive, Range(most=_FASTEST)]  # Hz, ticks per simulated second
    duration: Annotated[Positive, Range(most=_LONGEST)]  # s, simulated
    initial_stack: str  # a name of config/stacks
    transition: TransitionConfig  # how the controller goes from stack to stack
    events: tuple[EventConfig, ...] = ()  # what happens when
    # first goals by robot, m and rad; default: where it starts
    ee_target: dict[str, PoseConfig] = field(default_factory=dict)
    # first goals by robot, x [m], y [m], yaw [rad]; default: where it starts
    base_target: dict[str, Vector3] = field(default_factory=dict)
    obstacles: dict[str, ObstacleConfig] = field(default_factory=dict)  # by name
    plant: PlantConfig = field(default_factory=PlantConfig)  # default: as its model says
    timeouts: TimeoutsConfig = field(default_factory=TimeoutsConfig)  # how long who waits for whom
    lead_in: NotNegative = 0.5  # s, in which a reference moves to a new target; 0: it steps
    # what topics of references leave open
    references: ReferenceTopicsConfig = field(default_factory=ReferenceTopicsConfig)
    limit_jerk: bool = False  # at every tick, not only in transitions by bridge_jerk
    # the MPC, where there are sequences
    htmpc: HtmpcRunConfig = field(default_factory=HtmpcRunConfig)
    sequences: dict[str, SequenceConfig] = field(default_factory=dict)  # by name
    streams: tuple[StreamConfig, ...] = ()  # of targets
    solvers: int = 1  # processes that solve for the controller, each for some of the robots
    solver: str = "kernel"  # a key of lexstack.hqp.SOLVERS
    mode: Mode = "lockstep"  # wait for every tick's answers, or follow the clock
    seed: int = 0  # of everything random
    extensions: tuple[_Module, ...] = ()  # Python modules that register methods, solvers, tasks

    @property
    def horizon_ticks(self) -> int:
        """How many ticks ahead of the present one something may be asked for."""
        return round(self.timeouts.target_horizon * self.rate)

    @property
    def plans(self) -> bool:
        """Whether the HTMPC runs beside the controllers."""
        return bool(self.sequences) or self.htmpc.always

    @property
    def stacks_named(self) -> frozenset[str]:
        """The stacks that the scenario itself asks for."""
        switched = (event.switch for event in self.events if event.switch)
        return frozenset((self.initial_stack, *switched))

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for unknown robots and values out of range."""
        self._check_counts(where)
        targets: list[tuple[str, Mapping[str, object]]] = [
            ("ee_target", self.ee_target),
            ("base_target", self.base_target),
        ]
        for i, event in enumerate(self.events):
            targets += [(f"events[{i}].{key}", getattr(event, key)) for key in TARGETS]
            if event.at >= self.duration:
                raise ConfigurationError(f"{where}: events[{i}].at: after the scenario's end")
        pushed = [(f"plant.pushes[{i}]", [push.robot]) for i, push in enumerate(self.plant.pushes)]
        streamed = [(f"streams[{i}]", [entry.robot]) for i, entry in enumerate(self.streams)]
        switched = [(f"events[{i}].robots", event.robots) for i, event in enumerate(self.events)]
        planned = [(f"sequences.{name}", [entry.robot]) for name, entry in self.sequences.items()]
        for i, event in enumerate(self.events):
            planned += [(f"events[{i}].changes", [change.robot]) for change in event.changes]
            for name in event.execute:
                if name not in self.sequences:
                    known = ", ".join(self.sequences) or "none"
                    raise ConfigurationError(
                        f"{where}: events[{i}].execute: unknown {shown(name)}; known: {known}"
                    )
        for key, by_robot in [*targets, *pushed, *streamed, *switched, *planned]:
            for robot in by_robot:
                if robot not in self.robots:
                    known = ", ".join(self.robots)
                    raise ConfigurationError(
                        f"{where}: {key}: unknown robot {robot!r}; known: {known}"
                    )

    def _check_counts(self, where: str) -> None:
        """Raise ConfigurationError for more solvers than robots."""
        if not 1 <= self.solvers <= len(self.robots):
            raise ConfigurationError(
                f"{where}: solvers: must be in [1, {len(self.robots)}], one for each robot at most"
            )


def pose_from_config(config: PoseConfig) -> Pose:
    """Return a configured pose as a value."""
    # By way of the package, which loads pinocchio now: a recorder has no need of it.
    return lexstack.robots.Pose(
        np.array(config.position, dtype=np.float64),
        lexstack.robots.from_quaternion(np.array(config.orientation, dtype=np.float64)),
    )
