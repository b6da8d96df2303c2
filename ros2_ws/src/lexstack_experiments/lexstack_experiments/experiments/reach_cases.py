"""Targets out of reach, and within: random ones, drawn from a seed."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np

from lexstack.robots import Pose, Team, from_rpy
from lexstack.tasks import LevelConfig, StackConfig, TaskConfig
from lexstack.types import Vector
from lexstack_config.resolved import ResolvedScenario

REACH = 1.25  # m from the shoulder: no tool of the Panda comes so far
SHOULDER = 0.841  # m above the floor
HIGHEST = 2.1  # m: no tool of a Panda on its platform comes so high

KINDS = {
    "free": ("ee_pose", "velocity_damping"),
    "free position": ("ee_position", "velocity_damping"),
    "held": ("base", "ee_pose", "velocity_damping"),
    "held position": ("base", "ee_position", "velocity_damping"),
    "two robots": ("ee_pose", "velocity_damping"),
    "posture": ("ee_pose", "posture", "velocity_damping"),
    "base below": ("ee_pose", "base", "velocity_damping"),
    "relative": ("base", "relative_pose", "velocity_damping"),
    "nested": ("base", "relative_pose", "ee_pose", "velocity_damping"),
}
"""The stacks by what is asked for."""

SEVERAL = ("nested",)
"""Kinds with more than one level out of reach."""

_BOTH = ("two robots", "relative", "nested")
_HIGHEST = (0.0, -0.25537627, 0.0, -0.46700247, 0.0, 3.03484281, 0.0)  # rad: the arm straight up


@dataclass(frozen=True)
class Case:
    """One target, or one for each of two robots.

    Attributes:
        kind: key of ``KINDS``.
        beyond: how far out of reach, at least [m]; negative: within.
        tools: the reference of each robot's tool.
        bases: the reference of each robot's base.
    """

    kind: str
    beyond: float
    tools: tuple[Pose, ...]
    bases: tuple[Vector, ...] = field(default=())

    @property
    def robots(self) -> int:
        """How many robots there are."""
        return len(self.tools)

    @property
    def stack(self) -> StackConfig:
        """The stack that serves it."""
        return stack_of(self.kind)


def stack_of(kind: str) -> StackConfig:
    """Return the stack of a kind of case."""
    levels = []
    for name in KINDS[kind]:
        task = TaskConfig(name)
        if name == "relative_pose":
            task = TaskConfig(name, robot="robot_a", parameters={"other": "robot_b"})
        levels.append(LevelConfig((task,)))
    return StackConfig(kind, "", tuple(levels))


def scenario(resolved: ResolvedScenario, case: Case) -> ResolvedScenario:
    """Return a scenario of two robots with a case's robots and stack, and no events."""
    names = list(resolved.scenario.robots)[: case.robots]
    kept = dataclasses.replace(
        resolved.scenario,
        robots={name: resolved.scenario.robots[name] for name in names},
        events=(),
        initial_stack=case.kind,
        ee_target={},
        base_target={},
    )
    return dataclasses.replace(resolved, scenario=kept, stacks={case.kind: case.stack})


def out_of_reach(kind: str, rng: np.random.Generator, team: Team, home: Vector) -> Case:
    """Return a case whose targets cannot be reached, 0.05 m to 2 m beyond."""
    beyond = float(rng.uniform(0.05, 2.0))
    return _case(kind, beyond, rng, team, home)


def _case(kind: str, beyond: float, rng: np.random.Generator, team: Team, home: Vector) -> Case:
    """Return a case with targets at a distance from the boundary of what can be reached."""
    tools, bases = [], []
    count = 2 if kind in _BOTH else 1
    starts = team.tools(home)
    for robot in range(count):
        base = home[team.slices[robot]][:3]
        turn = from_rpy(tuple(rng.uniform(-1.2, 1.2, 3)))
        if KINDS[kind][0] == "base":
            position = base * [1, 1, 0] + [0, 0, SHOULDER] + (REACH + beyond) * _direction(rng)
        else:
            aside = rng.uniform(-1.0, 1.0, 2)
            position = np.array([*(base[:2] + aside), HIGHEST + beyond])
        if kind in ("relative", "nested"):
            turn = from_rpy(tuple(rng.uniform(-0.4, 0.4, 3)))
            position = starts[robot].position
            if robot == 1:
                apart = position - tools[0].position
                length = float(np.linalg.norm(apart))
                away = length + 2.0 * REACH + 0.25 * beyond
                position = tools[0].position + away / length * (turn @ apart)
        tools.append(Pose(position, turn @ starts[robot].rotation))
        bases.append(base.copy())
    return Case(kind, beyond, tuple(tools), tuple(bases))


def straight_up(beyond: float, team: Team, home: Vector) -> Case:
    """Return a target for the tool that far above the highest point that it comes to [m]."""
    q = home[team.slices[0]].copy()
    q[3:] = _HIGHEST
    best = team.robots[0].tool(q)[0]
    above = Pose(best.position + np.array([0.0, 0.0, beyond]), best.rotation)
    return Case("free position", beyond, (above,), (q[:3].copy(),))


def _direction(rng: np.random.Generator) -> Vector:
    """Return a direction that is not far below the horizon, shape (3,)."""
    height, side = rng.uniform(-0.3, 1.0), rng.uniform(-np.pi, np.pi)
    flat = np.sqrt(1.0 - height**2)
    return np.array([flat * np.cos(side), flat * np.sin(side), height])


def within_reach(kind: str, rng: np.random.Generator, team: Team, home: Vector) -> Case:
    """Return a case whose targets are poses of the robots, every second one near the boundary."""
    tools, bases = [], []
    count = 2 if kind in _BOTH else 1
    stretched = bool(rng.integers(2))
    limits = team.limits
    for robot in range(count):
        part = team.slices[robot]
        q = home[part].copy()
        lower, upper = limits.position_lower[part][3:], limits.position_upper[part][3:]
        middle, half = 0.5 * (upper + lower), 0.5 * (upper - lower)
        q[3:] = middle + 0.8 * half * rng.uniform(-1.0, 1.0, 7)
        if stretched:
            q[6] = rng.uniform(-0.35, -0.1)
        if KINDS[kind][0] != "base":
            q[:3] += rng.uniform(-0.5, 0.5, 3)
        tools.append(team.robots[robot].tool(q)[0])
        bases.append(q[:3].copy())
    return Case(kind, -1.0, tuple(tools), tuple(bases))
