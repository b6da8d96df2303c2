"""The schema of ``config/scenarios/*.yaml``: robots, timing, and what happens when."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

import lexstack.robots
from lexstack.errors import ConfigurationError
from lexstack.mpc import SequenceConfig
from lexstack.options import at_most, finite, names, not_negative, positive, shown
from lexstack.robots import ObstacleConfig, Vector3
from lexstack.transition import TransitionConfig
from lexstack_config.plant import PlantConfig
from lexstack_config.stream import StreamConfig

if TYPE_CHECKING:
    from lexstack.robots import Pose

Quaternion = tuple[float, float, float, float]
Mode = Literal["lockstep", "realtime"]
_FASTEST = 1000.0  # Hz, the plant's own steps
_LONGEST = 1e6  # s, 11 days


@dataclass(frozen=True, slots=True)
class PlacementConfig:
    """One robot of the scenario: its kind, and where its base starts, or is mounted."""

    model: str  # a name of config/robots
    base: Vector3 = (0.0, 0.0, 0.0)  # x [m], y [m], yaw [rad] in the world frame
    z: float = 0.0  # m, height of the mounting of a robot without a base

    @property
    def mounting(self) -> tuple[float, float, float, float]:
        """Where a robot without a base stands in the world: x, y, z [m], yaw [rad]."""
        x, y, yaw = self.base
        return x, y, self.z, yaw

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a model that is no name, or a place that is not finite."""
        names(where, model=self.model)
        finite(where, base=self.base, z=self.z)


@dataclass(frozen=True, slots=True)
class PoseConfig:
    """A pose in the world frame."""

    position: Vector3  # m
    orientation: Quaternion  # x, y, z, w

    def validate(self, where: str) -> None:
        """Raise ConfigurationError unless the quaternion has unit length."""
        finite(where, position=self.position, orientation=self.orientation)
        norm = sum(value * value for value in self.orientation) ** 0.5
        if abs(norm - 1.0) > 1e-3:
            raise ConfigurationError(f"{where}: orientation: norm must be 1, got {norm:.4f}")


@dataclass(frozen=True, slots=True)
class TimeoutsConfig:
    """Every wait has an end."""

    source_wall: float = 1.0  # s of wall time that A waits for B's chi of a tick (lockstep)
    source_stale: float = 0.05  # s of simulated time after which B's chi is stale (realtime)
    source_patience: float = 0.5  # s of simulated time that A waits for B's first chi (realtime)
    plan_stale: float = 0.25  # s of simulated time after which a plan is stale (realtime)
    command_wall: float = 2.0  # s of wall time that the bridge waits for a command (lockstep)
    watchdog: float = 0.1  # s of simulated time without a command after which all joints brake
    target_horizon: float = 60.0  # s of simulated time that a target's stamp may be ahead

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a timeout that is not positive."""
        positive(
            where,
            source_wall=self.source_wall,
            source_stale=self.source_stale,
            source_patience=self.source_patience,
            plan_stale=self.plan_stale,
            command_wall=self.command_wall,
            watchdog=self.watchdog,
            target_horizon=self.target_horizon,
        )


@dataclass(frozen=True, slots=True)
class HtmpcRunConfig:
    """How the HTMPC runs beside the controllers."""

    parameters: str = "lexstack"  # a file of config/htmpc
    rate: float = 20.0  # Hz, plans per simulated second; rounded to whole ticks
    always: bool = False  # whether its node runs also where the scenario has no sequences

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a rate that is not positive."""
        positive(where, rate=self.rate)

    def ticks(self, rate: float) -> int:
        """Return the ticks from plan to plan, given the ticks per second."""
        return max(1, round(rate / self.rate))


@dataclass(frozen=True, slots=True)
class SequenceChangeConfig:
    """A change of a sequence that is being executed."""

    robot: str
    change: Literal["release", "retarget", "cancel"]
    task: str  # its name
    points: tuple[tuple[float, ...], ...] = ()  # retarget: where it leads now


@dataclass(frozen=True, slots=True)
class EventConfig:
    """What happens at one time: new references, and perhaps a switch of the stack."""

    at: float  # s, simulated
    switch: str = ""  # the stack to switch to; empty: none
    duration: float = 0.0  # s of the transition; 0: from the scenario's transition
    robots: tuple[str, ...] = ()  # that switch; empty: all that the stack moves
    ee_target: dict[str, PoseConfig] = field(default_factory=dict)  # by robot
    base_target: dict[str, Vector3] = field(default_factory=dict)  # by robot: x, y, yaw
    execute: tuple[str, ...] = ()  # names of sequences that begin
    changes: tuple[SequenceChangeConfig, ...] = ()  # of sequences that are under way

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for negative times."""
        not_negative(where, at=self.at, duration=self.duration)


@dataclass(frozen=True, slots=True)
class ScenarioConfig:
    """A whole run."""

    name: str
    description: str
    robots: dict[str, PlacementConfig]  # in the order of chi
    rate: float  # Hz, ticks per simulated second
    duration: float  # s, simulated
    initial_stack: str
    transition: TransitionConfig
    events: tuple[EventConfig, ...] = ()
    ee_target: dict[str, PoseConfig] = field(default_factory=dict)  # default: where it starts
    base_target: dict[str, Vector3] = field(default_factory=dict)  # default: where it starts
    obstacles: dict[str, ObstacleConfig] = field(default_factory=dict)  # by name
    plant: PlantConfig = field(default_factory=PlantConfig)  # default: as its model says
    timeouts: TimeoutsConfig = field(default_factory=TimeoutsConfig)
    lead_in: float = 0.5  # s, in which a reference moves to a new target; 0: it steps
    limit_jerk: bool = False  # at every tick, not only in transitions by bridge_jerk
    htmpc: HtmpcRunConfig = field(default_factory=HtmpcRunConfig)
    sequences: dict[str, SequenceConfig] = field(default_factory=dict)  # by name
    streams: tuple[StreamConfig, ...] = ()  # of targets
    solvers: int = 1  # processes that solve for robot A, each for some of the robots
    solver: str = "daqp"  # a key of lexstack.hqp.SOLVERS
    mode: Mode = "lockstep"
    seed: int = 0

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
        names(where, name=self.name)
        names(where, ros=True, robots=self.robots)
        positive(where, rate=self.rate, duration=self.duration)
        not_negative(where, lead_in=self.lead_in)
        at_most(where, _FASTEST, rate=self.rate)
        at_most(where, _LONGEST, duration=self.duration)
        self._check_counts(where)
        targets: list[tuple[str, dict[str, PoseConfig] | dict[str, Vector3]]] = [
            ("ee_target", self.ee_target),
            ("base_target", self.base_target),
        ]
        for i, event in enumerate(self.events):
            targets += [
                (f"events[{i}].ee_target", event.ee_target),
                (f"events[{i}].base_target", event.base_target),
            ]
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
        """Raise ConfigurationError without robots, or for more solvers than robots."""
        if not self.robots:
            raise ConfigurationError(f"{where}: robots: at least one robot is needed")
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
