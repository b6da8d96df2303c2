"""Random reaches of an arm: from a random configuration to the tool's pose at another one."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lexstack.robots import Pose, RobotModel, Team
from lexstack.types import Vector
from lexstack_config.resolved import load_robot

ROBOTS = ("panda", "ur10", "xarm7")
DT = 0.01  # s
MARGIN = 0.05  # of a joint's range, at either end, that starts and goals keep
_FREE = 1e4, 1e8  # rad/s2, rad/s3: no joint can use more within a period


@dataclass(frozen=True, slots=True)
class Reach:
    """From where to where.

    Attributes:
        start: the arm at rest, shape (n,), rad.
        goal: of the tool, in the world; the arm can reach it inside its limits.
    """

    start: Vector
    goal: Pose


def arm(config: Path, name: str, *, free: bool = False) -> Team:
    """Return a team of one arm of the configuration folder, fixed at the origin.

    Args:
        config: the folder.
        name: of the robot.
        free: whether it has limits of position and velocity alone.
    """
    kind = load_robot(config / "robots" / f"{name}.yaml")
    if free:
        n = len(kind.arm.joints)
        limits = {"acceleration": (_FREE[0],) * n, "jerk": (_FREE[1],) * n}
        kind = dataclasses.replace(kind, arm=dataclasses.replace(kind.arm, **limits))
    return Team((RobotModel(name, kind),), DT)


def random_reach(team: Team, rng: np.random.Generator) -> Reach:
    """Return a reach of the only robot of a team."""
    start, end = _inside(team, rng), _inside(team, rng)
    return Reach(start, team.tools(end)[0])


def _inside(team: Team, rng: np.random.Generator) -> Vector:
    """Return a configuration inside the position limits, with a margin."""
    lower, upper = team.limits.position_lower, team.limits.position_upper
    share = rng.uniform(MARGIN, 1.0 - MARGIN, team.n)
    return np.asarray(lower + share * (upper - lower))
