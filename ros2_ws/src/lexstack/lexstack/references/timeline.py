"""The controller's decisions on references, and what follows from them at any tick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from lexstack.references.set_point import settled, unled
from lexstack.references.trajectory import Trajectory
from lexstack.references.values import STILL, TOOL, Frame, Motion, References
from lexstack.robots import Pose
from lexstack.types import Vector

ROUNDING = 1e-9  # s, of stamps
"""Stamps that differ by less are the same [s]."""
K = TypeVar("K")

_MOST = 256  # decisions that are kept, for one that is to come or late


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """One decision: the references of all robots from a tick on, each a trajectory.

    Attributes:
        at: simulated time of the tick [s].
        revision: counts the decisions from 1 on.
        ee: of the tools, in the team's order.
        base: of the bases.
        frames: of further frames that were given one.
        postures: of the arms that were given one, by robot.
    """

    at: float
    revision: int
    ee: tuple[Trajectory[Pose], ...]
    base: tuple[Trajectory[Vector], ...]
    frames: Mapping[Frame, Trajectory[Pose]] = field(default_factory=dict)
    postures: Mapping[int, Trajectory[Vector]] = field(default_factory=dict)

    def settled(self, stamp: float) -> bool:
        """Return whether no reference moves at a time [s] or later."""
        return (
            all(settled(point, stamp) for point in self.ee)
            and all(settled(point, stamp) for point in self.base)
            and all(settled(point, stamp) for point in self.frames.values())
            and all(settled(point, stamp) for point in self.postures.values())
        )

    def unled(self) -> Setting:
        """Return the decision as if nothing had been led in: set-points and trajectories alone."""
        return replace(
            self,
            ee=tuple(unled(point) for point in self.ee),
            base=tuple(unled(point) for point in self.base),
            frames={key: unled(point) for key, point in self.frames.items()},
            postures={robot: unled(point) for robot, point in self.postures.items()},
        )

    def references(self, stamp: float, ahead: float = 0.0) -> References:
        """Return the references at a time [s], and their velocities ``ahead`` seconds later."""
        return References(
            tuple(point.at(stamp) for point in self.ee),
            tuple(point.at(stamp) for point in self.base),
            self.revision,
            self._motion(stamp, stamp + ahead),
        )

    def _motion(self, stamp: float, later: float) -> Motion:
        """Return the further references at a time [s], and all velocities at a later one."""
        twists: dict[Frame, Trajectory[Pose]] = {
            (robot, TOOL): point for robot, point in enumerate(self.ee)
        }
        moving = _rates(twists | dict(self.frames), later)
        bases = _rates(dict(enumerate(self.base)), later)
        if not (moving or bases or self.frames or self.postures):
            return STILL
        return Motion(
            moving,
            bases,
            {key: point.at(stamp) for key, point in self.frames.items()},
            {robot: point.at(stamp) for robot, point in self.postures.items()},
            _rates(self.postures, later),
        )


def _rates(points: Mapping[K, Trajectory[Any]], stamp: float) -> dict[K, Vector]:
    """Return the velocities at a time [s] of those that have one."""
    rates = {key: point.rate(stamp) for key, point in points.items()}
    return {key: rate for key, rate in rates.items() if rate is not None}


class ReferenceTimeline:
    """Decisions in their order, and the references at any tick.

    All who hear the same decisions have the same references, bit for bit.

    A command holds for a whole control period, in which the reference moves by its velocity in the
    middle of it, but for terms of third order. The velocities are therefore those of half a period
    later; those at the beginning would leave an error of a dt / (2 K).
    """

    def __init__(self, dt: float = 0.0) -> None:
        """Start without any decision; ``dt`` is the control period [s]."""
        self._ahead = 0.5 * dt
        self._settings: list[Setting] = []
        self._last: tuple[Setting, bool, References] | None = None

    @property
    def newest(self) -> Setting | None:
        """The last decision."""
        return self._settings[-1] if self._settings else None

    def hear(self, setting: Setting) -> bool:
        """Take a decision; return whether it is new.

        One for an earlier time than the last begins anew: the plant was reset.
        """
        last = self.newest
        if last is not None and setting.at < last.at - ROUNDING:
            self._settings = []
        elif last is not None and setting.revision <= last.revision:
            return False
        self._settings = [*self._settings[1 - _MOST :], setting]
        return True

    def covers(self, stamp: float) -> bool:
        """Return whether the references are known at a time [s]."""
        return bool(self._settings) and self._settings[0].at <= stamp + ROUNDING

    def at(self, stamp: float) -> References:
        """Return the references at a time [s]: the same object for as long as none changes.

        Before the first decision they are those of the first one.
        """
        setting = self._at(stamp)
        if self._last is not None and self._last[0] is setting and self._last[1]:
            return self._last[2]
        references = setting.references(stamp, self._ahead)
        self._last = (setting, setting.settled(stamp), references)
        return references

    def of_revision(self, revision: int, stamp: float) -> References:
        """Return the references at a time [s] by a known decision; by the one in effect if not."""
        for setting in self._settings:
            if setting.revision == revision:
                return setting.references(stamp, self._ahead)
        return self.at(stamp)

    def _at(self, stamp: float) -> Setting:
        """Return the decision in effect at a time [s]."""
        for setting in reversed(self._settings):
            if setting.at <= stamp + ROUNDING:
                return setting
        return self._settings[0]
