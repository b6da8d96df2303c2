"""The controller's decisions on references, and what follows from them at any tick."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.references.set_point import BASES, POSES, SetPoint
from lexstack.references.values import References
from lexstack.robots import Pose
from lexstack.types import Vector

ROUNDING = 1e-9  # s, of stamps
"""Stamps that differ by less are the same [s]."""
_MOST = 256  # decisions that are kept, for one that is to come or late


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """One decision: the set-points of all robots from a tick on.

    Attributes:
        at: simulated time of the tick [s].
        revision: counts the decisions from 1 on.
        ee: of the tools, in the team's order.
        base: of the bases.
    """

    at: float
    revision: int
    ee: tuple[SetPoint[Pose], ...]
    base: tuple[SetPoint[Vector], ...]

    def settled(self, stamp: float) -> bool:
        """Return whether no reference moves at a time [s] or later."""
        return all(point.settled(stamp) for point in self.ee) and all(
            point.settled(stamp) for point in self.base
        )

    def references(self, stamp: float) -> References:
        """Return the references at a time [s]."""
        return References(
            tuple(point.at(stamp, POSES) for point in self.ee),
            tuple(point.at(stamp, BASES) for point in self.base),
            self.revision,
        )


class ReferenceTimeline:
    """Decisions in their order, and the references at any tick.

    All who hear the same decisions have the same references, bit for bit.
    """

    def __init__(self) -> None:
        """Start without any decision."""
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
        references = setting.references(stamp)
        self._last = (setting, setting.settled(stamp), references)
        return references

    def of_revision(self, revision: int, stamp: float) -> References:
        """Return the references at a time [s] by a known decision; by the one in effect if not."""
        for setting in self._settings:
            if setting.revision == revision:
                return setting.references(stamp)
        return self.at(stamp)

    def _at(self, stamp: float) -> Setting:
        """Return the decision in effect at a time [s]."""
        for setting in reversed(self._settings):
            if setting.at <= stamp + ROUNDING:
                return setting
        return self._settings[0]
