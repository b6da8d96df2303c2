"""A random run of the bridge: what is promised of every transition, judged by others.

(i) The problem is feasible in every tick; (ii) the command keeps the limits of velocity and
acceleration, and the joints those of position; (iii) the command is continuous where a blend
begins; (iv) level 1 is as good as an independent solver makes it within the same bounds, where all
stacks share it. A target that steps in a blend makes level 1 itself be bridged: (iii) and (iv) are
not judged from there to the end of the blend.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from scipy.optimize import lsq_linear

from lexstack.control import Command
from lexstack.errors import ConfigurationError
from lexstack.limits import viable_bounds
from lexstack.options import NotEmpty, NotNegative, Positive, shown
from lexstack.references import Target
from lexstack.transition import SourceSample, TransitionConfig
from lexstack.types import RobotState, Vector
from lexstack_config.parts import Parts
from lexstack_config.reader import build
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.links import Delayed
from lexstack_experiments.loop import Loop
from lexstack_experiments.runs import changed, scenario_of
from lexstack_experiments.sweeps.kinds.kind import Row

_EVERY = 10  # ticks between two checks of level 1
_QUINTIC = 5.774  # largest second derivative of the quintic blend of 1 in 1 s


Stacks = Annotated[tuple[str, ...], NotEmpty("at least one stack is needed")]


@dataclass(frozen=True, slots=True)
class Chances:
    """What happens in a run; all of it is drawn with the run's seed."""

    seed: int  # of this run
    stacks: Stacks = ("track", "reach_base", "posture_mid_range")  # that are switched to
    ticks: int = 100  # of the run
    duration: Positive = 0.2  # s, of a blend
    requests: int = 2  # switches that are asked for, at any ticks
    method: str = "bridge"  # of the transition
    lost: NotNegative = 0.0  # chance that a chi of the solver is lost, of each
    away: int = 0  # ticks that the solver is away, from any tick on
    late: int = 0  # ticks that a chi of the solver comes late
    spread: NotNegative = 0.4  # rad and m, of the start around home
    speed: NotNegative = 0.1  # rad/s and m/s, of the start
    targets: int = 0  # new targets of tools, at any times
    reach: NotNegative = 0.5  # m, how far a new target is from where the tool starts

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for counts that a run cannot have."""
        if self.ticks < 2 or min(self.requests, self.away, self.late, self.targets) < 0:
            raise ConfigurationError(f"{where}: counts must not be negative, ticks at least 2")
        if self.lost > 1.0:
            raise ConfigurationError(f"{where}: lost: a chance is at most 1, got {self.lost:g}")


def promises_run(config: Path, of: str, values: Mapping[str, Any]) -> Row:
    """Run a scenario's robots through random switches, and return the worst of every promise.

    Raises:
        ConfigurationError: a value is none of ``Chances``, or does not fit.
    """
    chances = build(Chances, dict(values), "the sweep's values")
    resolved, parts = _parts(config, of or "transition-sequence")
    for stack in chances.stacks:
        if stack not in parts.stacks:
            raise ConfigurationError(f"stacks: unknown {shown(stack)}")
    watch = _Watch(_loop(resolved, parts, chances), chances, _shared(resolved, chances))
    for _ in range(chances.ticks):
        watch.step()
    return watch.row()


@lru_cache(maxsize=4)
def _parts(config: Path, name: str) -> tuple[ResolvedScenario, Parts]:
    """Return a scenario and what is built of it, which takes longer than a run."""
    resolved = scenario_of(config, name)
    return resolved, Parts.of(resolved)


def _loop(resolved: ResolvedScenario, parts: Parts, chances: Chances) -> Loop:
    """Return the closed loop of a run, ready to go."""
    rng = np.random.default_rng(chances.seed)
    stacks = [str(rng.choice(chances.stacks)) for _ in range(chances.requests + 1)]
    scenario = changed(
        resolved,
        initial_stack=stacks[0],
        events=(),
        transition=TransitionConfig(duration=chances.duration, method=chances.method),
        mode="realtime" if chances.late or chances.lost else "lockstep",
    )
    plant = IdealPlant(scenario, parts.team)
    plant.put(*_start(parts, plant.state().q, chances, rng))
    loop = Loop(scenario, plant, parts=parts)
    loop.link = _Link(chances.late, chances.lost, rng.spawn(1)[0])
    gone = int(rng.integers(chances.ticks))
    loop.solver_answers = lambda tick: not gone <= tick < gone + chances.away
    for stack in stacks[1:]:
        loop.controller.transition.ask(stack, 0.0, "", int(rng.integers(1, chances.ticks)))
    for _ in range(chances.targets):
        loop.add_target(_target(loop, chances, rng))
    return loop


def _shared(resolved: ResolvedScenario, chances: Chances) -> bool:
    """Return whether all stacks have the same level 1, and leave the robots' limits as they are."""
    stacks = [resolved.stacks[name] for name in chances.stacks]
    return all(stack.levels[0] == stacks[0].levels[0] and not stack.limits for stack in stacks)


def _start(
    parts: Parts, home: Vector, chances: Chances, rng: np.random.Generator
) -> tuple[Vector, Vector]:
    """Return a configuration around home, and a velocity from which the robots can still stop."""
    limits, at = parts.team.limits, parts.team.joint_positions(home)
    inside = np.where(np.isfinite(limits.position_lower), 0.2, 0.0)
    inside *= np.where(inside > 0.0, limits.position_upper - limits.position_lower, 0.0)
    way = rng.uniform(-chances.spread, chances.spread, limits.velocity.size)
    way = np.clip(way, limits.position_lower + inside - at, limits.position_upper - inside - at)
    q = parts.team.integrate(home, way, 1.0)
    return q, rng.uniform(-chances.speed, chances.speed, limits.velocity.size)


def _target(loop: Loop, chances: Chances, rng: np.random.Generator) -> Target:
    """Return a new target of a tool at any time; one far away is out of reach."""
    team, state = loop.parts.team, loop.plant.state()
    robot = int(rng.integers(len(team.robots)))
    pose = team.tools(state.q)[robot]
    way = rng.normal(size=3)
    way *= chances.reach / np.linalg.norm(way)
    at = loop.parts.dt * int(rng.integers(1, chances.ticks))
    return Target(at, robot, ee=replace(pose, position=pose.position + way))


class _Link:
    """Loses some messages, and is late with all others."""

    def __init__(self, late: int, lost: float, rng: np.random.Generator) -> None:
        """Start with nothing on its way."""
        self._delay = Delayed(late)
        self._lost, self._rng = lost, rng

    def __call__(self, sample: SourceSample) -> SourceSample | None:
        """Take a message in, and give out the one that arrives, if any."""
        arrives = self._delay(sample)
        return None if self._rng.random() < self._lost else arrives


@dataclass(slots=True)
class _Watch:
    """Runs a loop, and keeps the worst of every promise."""

    loop: Loop
    chances: Chances
    shared: bool  # whether level 1 is the same in all stacks, and so are the limits
    empty: int = 0
    fallbacks: int = 0
    velocity: float = 0.0
    acceleration: float = 0.0
    position: float = 0.0
    jump: float = -np.inf
    level_1: float = -np.inf
    _before: Vector = field(init=False)
    _change: float = 0.0  # of the command at the tick before, at most
    _widest: float = 0.0  # gap of a blend so far
    _revision: int | None = None  # of the references at the tick before
    _bridged: bool = False  # whether level 1 is bridged, since a target came in a blend

    def __post_init__(self) -> None:
        """Begin with the command in force."""
        self._before = self.loop.plant.state().command

    def step(self) -> None:
        """Serve a tick and judge it."""
        state = self.loop.plant.state()
        command = self.loop.step()
        limits, dt = self.loop.parts.team.limits, self.loop.parts.dt
        change = np.abs(command.chi - self._before)
        self.empty += command.bounds.empty
        self.fallbacks += bool(command.fallback)
        self.velocity = max(self.velocity, float((np.abs(command.chi) / limits.velocity).max()))
        self.acceleration = max(
            self.acceleration, float((change / (dt * limits.acceleration)).max())
        )
        self.position = max(self.position, _beyond(self.loop))
        if not self._level_1_bridged(command):
            self._continuity(command, float(change.max()))
            if self.shared and command.tick % _EVERY == 0:
                self._best(state, command)
        self._before, self._change = command.chi, float(change.max())

    def _level_1_bridged(self, command: Command) -> bool:
        """Return whether a target came in a blend that is not at its end yet."""
        revision = self.loop.record.references[-1].revision
        blending = command.transition.alpha < 1.0
        came = revision != self._revision and command.tick > 0
        self._bridged = blending and (self._bridged or came)
        self._revision = revision
        return self._bridged

    def _continuity(self, command: Command, change: float) -> None:
        """Judge promise (iii): where alpha is 0 the command changes as it did before.

        What is left is a small part of the gap, the drift of level 1's own rows, and by how much
        that changes in a tick of the blend before.
        """
        transition, dt = command.transition, self.loop.parts.dt
        if transition.alpha == 0.0 and transition.source.value and command.tick > 1:
            bend = _QUINTIC * self._widest * (dt / self.chances.duration) ** 2
            allowed = 0.02 * transition.gap + 1.2 * self._change + bend + 2e-3
            self.jump = max(self.jump, change - allowed)
        self._widest = max(self._widest, transition.gap)

    def _best(self, state: RobotState, command: Command) -> None:
        """Judge promise (iv) by bounded least squares in the box of the limits."""
        parts = self.loop.parts
        kinematics = parts.team.kinematics(state)
        level = parts.stacks[self.chances.stacks[0]].levels[0]
        rows = level.linearise(kinematics, self.loop.solver_references.at(state.stamp))
        matrix = np.vstack([row.matrix for row in rows])
        target = np.concatenate([row.lower for row in rows])
        box = viable_bounds(state.q_star, parts.team.limits, parts.dt, state.command)
        ends = box.lower, np.maximum(box.upper, box.lower + 1e-12)
        best = lsq_linear(matrix, target, ends, tol=1e-14, method="bvls")
        ours = float(np.linalg.norm(matrix @ command.chi - target))
        self.level_1 = max(self.level_1, ours - float(np.sqrt(2.0 * best.cost)))

    def row(self) -> Row:
        """Return the worst of every promise; what no tick shows is left out."""
        row: Row = {
            "empty_boxes": self.empty,
            "fallbacks": self.fallbacks,
            "velocity_ratio": self.velocity,
            "acceleration_ratio": self.acceleration,
            "beyond_position_rad_or_m": self.position,
        }
        if np.isfinite(self.jump):
            row["jump_beyond_allowed"] = self.jump
        if np.isfinite(self.level_1):
            row["level_1_above_best"] = self.level_1
        return row


def _beyond(loop: Loop) -> float:
    """Return how far a joint is beyond its position limits [rad, m]; at most 0 inside."""
    limits = loop.parts.team.limits
    q = loop.parts.team.joint_positions(loop.plant.state().q)
    return float(np.maximum(q - limits.position_upper, limits.position_lower - q).max())
