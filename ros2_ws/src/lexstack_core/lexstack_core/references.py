"""References: where the end effectors and the bases shall be, and from when on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lexstack_core.config.scenario import PoseConfig, ScenarioConfig
from lexstack_core.errors import InputError
from lexstack_core.linear import Vector
from lexstack_core.model import Pose, Team
from lexstack_core.rotation import from_quaternion

_MOST = 10_000  # targets to come; a stream that is stamped in the future must not fill the memory


@dataclass(frozen=True, slots=True)
class References:
    """The references of all robots at one time, in the team's order, in the world frame.

    Attributes:
        ee: pose of each tool frame.
        base: x [m], y [m], yaw [rad] of each base, shape (3,) each.
        revision: counts robot A's decisions which targets are in effect; 0: none is counted. While
            a set-point is led in, the references move from tick to tick within one revision.
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


class ReferenceSchedule:
    """The references in effect, and those that are still to come."""

    def __init__(self, initial: References) -> None:
        """Start with ``initial`` in effect and nothing to come."""
        self._now = initial
        self._coming: list[Target] = []

    @classmethod
    def from_scenario(cls, scenario: ScenarioConfig, team: Team, home: Vector) -> ReferenceSchedule:
        """Return a scenario's first references; what it leaves out is the pose at ``home``."""
        tools = team.tools(home)
        return cls(
            References(
                tuple(
                    pose_from_config(scenario.ee_target[name])
                    if name in scenario.ee_target
                    else tool
                    for name, tool in zip(team.names, tools, strict=True)
                ),
                tuple(
                    np.array(scenario.base_target.get(name, home[part][:3]), dtype=np.float64)
                    for name, part in zip(team.names, team.slices, strict=True)
                ),
            )
        )

    def add(self, target: Target) -> None:
        """Take a new target; of two for the same time the later addition wins.

        Raises:
            InputError: too many targets are to come already.
        """
        if len(self._coming) >= _MOST:
            raise InputError(f"targets: {_MOST} are to come already, this one is left out")
        self._coming.append(target)
        self._coming.sort(key=lambda entry: entry.at)  # stable: keeps the order of arrival

    def at(self, stamp: float) -> References:
        """Return the references in effect at a time [s]; time must not run backwards."""
        while self._coming and self._coming[0].at <= stamp + 1e-9:
            self._now = _applied(self._now, self._coming.pop(0))
        return self._now


def pose_from_config(config: PoseConfig) -> Pose:
    """Return a configured pose as a value."""
    return Pose(
        np.array(config.position, dtype=np.float64),
        from_quaternion(np.array(config.orientation, dtype=np.float64)),
    )


def _applied(references: References, target: Target) -> References:
    """Return the references with one target put in."""
    i = target.robot
    result = references
    if target.ee is not None:
        result = replace(result, ee=(*result.ee[:i], target.ee, *result.ee[i + 1 :]))
    if target.base is not None:
        result = replace(result, base=(*result.base[:i], target.base, *result.base[i + 1 :]))
    return result
