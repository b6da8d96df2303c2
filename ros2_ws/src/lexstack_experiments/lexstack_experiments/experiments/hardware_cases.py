"""Cases of the experiment ``hardware``: the task sequence, and switches at random."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lexstack.robots import from_quaternion, from_rpy, to_quaternion
from lexstack_config.plant_file import PlantFile, load_plant
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig, PoseConfig
from lexstack_experiments.runs import changed, scenario_of, with_method

AHEAD = 5
"""Points that later trajectories do not change: late messages come 30 ms late, at 100 Hz."""

HABITS = {
    "none": "",
    "jitter of 2 ms": "jitter=0.002",
    "1 % lost": "drop=0.01",
    "1 % late by 30 ms": "late=0.01",
    "reordered, repeated": "reorder=1,repeat=0.01",
    "no velocities": "velocities=0",
    "encoders of 0.1 mrad": "quantum=1e-4",
    "odometry off by 1 %": "drift=0.01",
    "all": "all",
}
"""Habits of hardware, by what the table calls them."""

_STACKS = ("track", "reach_base", "posture", "posture_mid_range")
_TURN = 0.1  # rad
_BEFORE, _AFTER = (0.6, 1.4), 1.5  # s


@dataclass(frozen=True, slots=True)
class Switch:
    """One switch at random, of one robot that moves.

    Attributes:
        resolved: the scenario.
        tick: of the switch.
    """

    resolved: ResolvedScenario
    tick: int


def plant_of(config: Path) -> PlantFile:
    """Return the plant of the sequence, whose trajectories bridge late messages."""
    plant = load_plant(config / "plants" / "two_pandas.yaml")
    robots = {
        name: replace(robot, arm=replace(robot.arm, ahead=AHEAD))
        for name, robot in plant.robots.items()
    }
    return replace(plant, robots=robots)


def sequence(config: Path) -> ResolvedScenario:
    """Return the task sequence with one way to its last goal.

    At (C) of the paper robot B is to turn by 180 degrees: it may go either way, measurement noise
    decides, and one of the ways leads through robot A. Its goal is turned by 0.1 rad here.
    """
    resolved = scenario_of(config)
    *others, last = resolved.scenario.events
    pose = last.ee_target["robot_b"]
    turned = from_rpy((0.0, 0.0, _TURN)) @ from_quaternion(np.array(pose.orientation))
    x, y, z, w = to_quaternion(turned).tolist()
    goals = {**last.ee_target, "robot_b": PoseConfig(pose.position, (x, y, z, w))}
    return changed(resolved, events=(*others, replace(last, ee_target=goals)))


def switches(config: Path, method: str, seed: int, count: int) -> Iterator[Switch]:
    """Yield switches between random stacks of a robot on its way to random goals."""
    whole = scenario_of(config)
    robots = {"robot_a": whole.scenario.robots["robot_a"]}
    for number in range(count):
        random = np.random.default_rng((seed, number))
        before, after = random.choice(_STACKS, 2, replace=False).tolist()
        at = round(float(random.uniform(*_BEFORE)), 2)
        goal, next_goal = _goal(random), _goal(random)
        event = EventConfig(
            at,
            after,
            duration=float(random.choice([0.2, 0.5, 1.0])),
            ee_target={"robot_a": next_goal},
            base_target={"robot_a": _place(random)},
        )
        resolved = changed(
            whole,
            robots=robots,
            initial_stack=before,
            ee_target={"robot_a": goal},
            base_target={"robot_a": _place(random)},
            events=(event,),
            duration=at + _AFTER,
        )
        yield Switch(with_method(resolved, method), round(at * whole.scenario.rate))


def _goal(random: np.random.Generator) -> PoseConfig:
    """Return a goal of the tool before the robot."""
    x, y, z = (np.array([0.65, 0.0, 0.95]) + random.uniform(-0.2, 0.2, 3)).tolist()
    turn = from_rpy(tuple(random.uniform(-0.5, 0.5, 3))) @ from_rpy((np.pi, 0.0, 0.0))
    qx, qy, qz, qw = to_quaternion(turn).tolist()
    return PoseConfig((x, y, z), (qx, qy, qz, qw))


def _place(random: np.random.Generator) -> tuple[float, float, float]:
    """Return a goal of the base."""
    x, y, yaw = random.uniform(-0.4, 0.4, 3).tolist()
    return x, y, yaw
