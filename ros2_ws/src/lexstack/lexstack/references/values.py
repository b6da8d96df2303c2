"""References and targets as values."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.robots import Pose, Team
from lexstack.types import Vector


@dataclass(frozen=True, slots=True)
class References:
    """The references of all robots at one time, in the team's order, in the world frame.

    Attributes:
        ee: pose of each tool frame.
        base: x [m], y [m], yaw [rad] of each base, shape (3,) each; a robot without one has none
            that leads anywhere, and its mounting stands here.
        revision: number of the decision that they follow from; 0: of none. While a set-point is
            led in, the references move and the revision stays.
    """

    ee: tuple[Pose, ...]
    base: tuple[Vector, ...]
    revision: int = 0


@dataclass(frozen=True, slots=True)
class Target:
    """One new reference of one robot, from a time on.

    Attributes:
        at: simulated time from which it holds [s].
        robot: the robot's place in the team.
        ee: a pose of the tool, or None.
        base: x, y, yaw of the base, shape (3,), or None.
    """

    at: float
    robot: int
    ee: Pose | None = None
    base: Vector | None = None


def measured(team: Team, q: Vector) -> References:
    """Return the poses at the stacked configuration q, shape (n,), as references."""
    return References(team.tools(q), team.base_poses(q))
