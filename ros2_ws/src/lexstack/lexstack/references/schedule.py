"""Which references hold from which tick on: the controller decides it, for everybody."""

from __future__ import annotations

from bisect import insort
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lexstack.errors import InputError
from lexstack.references.along_heading import check_along_heading, check_drives
from lexstack.references.base_twist import BaseTwist
from lexstack.references.set_point import SetPoint
from lexstack.references.taking import taken
from lexstack.references.timeline import ROUNDING, ReferenceTimeline, Setting
from lexstack.references.twist_stream import Twist
from lexstack.references.values import TOOL, Hold, References, Target, measured
from lexstack.robots import Pose, Team
from lexstack.types import Vector

_MOST = 10_000  # targets to come of one robot and kind: a minute at 160 Hz


class ReferenceSchedule:
    """The targets that are still to come, and the decisions made so far.

    A decision is made once, for one tick: ``decide`` says which targets take effect there. Later
    targets take effect at a later tick, whatever their stamps are.

    Attributes:
        timeline: the decisions.
        lead_in: time in which a reference moves to a target that is still to be decided on [s].
    """

    def __init__(
        self,
        initial: References,
        *,
        lead_in: float = 0.0,
        horizon: float = float("inf"),
        dt: float = 0.0,
    ) -> None:
        """Start with ``initial`` as the first references.

        Args:
            initial: of all robots.
            lead_in: time in which the reference moves to a new target [s]; 0: it steps.
            horizon: how far ahead of the present a target's stamp may be [s].
            dt: control period [s], see ``ReferenceTimeline``.
        """
        self.timeline = ReferenceTimeline(dt)
        self._dt = dt
        self._initial = initial
        self._given: tuple[frozenset[int], frozenset[int]] | None = None
        self._unicycles: frozenset[int] = frozenset()  # robots whose bases cannot go sideways
        self.lead_in = lead_in
        self._horizon = horizon
        self._coming: dict[tuple[int, str], list[Target]] = defaultdict(list)
        self._decided = -float("inf")  # s, the last tick that was decided
        self._revision = 0
        self._news: list[Setting] = []

    @classmethod
    def at_home(
        cls,
        team: Team,
        home: Vector,
        ee: Mapping[str, Pose] | None = None,
        base: Mapping[str, Vector] | None = None,
        *,
        lead_in: float = 0.0,
        horizon: float = float("inf"),
    ) -> ReferenceSchedule:
        """Return a schedule whose first references are given by name, or where the robots start.

        What is left out is the pose at ``home``, shape (n,), until ``begin`` says where the robots
        are.

        Args:
            team: the robots.
            home: the configuration at which they are expected to start, shape (n,).
            ee: poses of tools, by robot.
            base: x [m], y [m], yaw [rad] of bases, shape (3,), by robot.
            lead_in: as in the class.
            horizon: as in the class.
        """
        ee, base = ee or {}, base or {}
        expected = measured(team, home)
        initial = References(
            tuple(ee.get(name, tool) for name, tool in zip(team.names, expected.ee, strict=True)),
            tuple(
                np.array(base.get(name, place), dtype=np.float64)
                for name, place in zip(team.names, expected.base, strict=True)
            ),
        )
        schedule = cls(initial, lead_in=lead_in, horizon=horizon, dt=team.dt)
        schedule._unicycles = frozenset(i for i, r in enumerate(team.robots) if r.differential)
        schedule._given = (
            frozenset(team.index(name) for name in ee),
            frozenset(team.index(name) for name in base),
        )
        return schedule

    @property
    def begun(self) -> bool:
        """Whether the first references are decided."""
        return self.timeline.newest is not None

    @property
    def next(self) -> float:
        """Time of the first tick that is not decided yet [s]: when a target of now takes effect."""
        return max(self._decided + self._dt, 0.0)

    def begin(self, present: References) -> None:
        """Take the measured poses for first references, where none are given.

        Robots that nobody has asked to move then stay where they are. Without effect after the
        first decision.
        """
        if self.begun or self._given is None:
            return
        ee, base = self._given
        first = self._initial
        self._initial = References(
            tuple(first.ee[i] if i in ee else pose for i, pose in enumerate(present.ee)),
            tuple(first.base[i] if i in base else place for i, place in enumerate(present.base)),
        )

    def resume(self, last: Setting, stamp: float) -> None:
        """Go on with another controller's last decision, from a time [s] on; see ``begin``."""
        if not self.begun:
            self._take(replace(last, at=stamp))

    def count_on(self, other: ReferenceSchedule) -> None:
        """Number the decisions after those of another schedule, which this one replaces."""
        self._revision = max(self._revision, other._revision)
        self._decided = -float("inf")

    def add(self, target: Target) -> None:
        """Take a new target; of two for the same time the later addition wins.

        Raises:
            InputError: its stamp is too far ahead, its robot has too many targets to come, or it is
                a trajectory on which a differential base would have to move to its side.
        """
        path = target.base
        if (
            target.robot in self._unicycles
            and path is not None
            and not isinstance(path, np.ndarray | Hold)
        ):
            if isinstance(path, BaseTwist):
                check_drives(path)
            else:
                check_along_heading(path, target.at)
        kind = target.kind
        if isinstance(target.ee, Twist) and target.frame != TOOL and not self._placed(target):
            raise InputError(f"{kind}: a twist needs a pose to begin from, give that first")
        ahead = target.at - max(self._decided, 0.0)
        if ahead > self._horizon:
            raise InputError(
                f"{kind}: stamp {target.at:.3f} s is {ahead:.6g} s ahead of the simulated time, "
                f"more than {self._horizon:g} s; stamp 0 means now"
            )
        coming = self._coming[target.robot, kind]
        insort(coming, target, key=lambda entry: entry.at)  # after those for the same time
        if len(coming) > _MOST:
            last = coming.pop()
            raise InputError(
                f"{kind}: {_MOST} are to come already, the one for {last.at:.3f} s is left out"
            )

    def decide(self, stamp: float) -> None:
        """Decide the references of the tick at a time [s]; each tick is decided once."""
        if stamp <= self._decided + ROUNDING:
            return
        self._decided = stamp
        last, due = self.timeline.newest, self._due(stamp)
        if last is not None and not due:
            return
        setting = last or Setting(
            stamp,
            0,
            tuple(SetPoint(pose) for pose in self._initial.ee),
            tuple(SetPoint(place) for place in self._initial.base),
        )
        for target in due:
            setting = taken(setting, target, stamp, self.lead_in)
        if setting is not last:
            self._take(replace(setting, at=stamp))

    def at(self, stamp: float) -> References:
        """Return the references of the tick at a time [s]; it is decided if it was not yet."""
        self.decide(stamp)
        return self.timeline.at(stamp)

    def take_news(self) -> list[Setting]:
        """Return the decisions since the last call, to be told to others."""
        news, self._news = self._news, []
        return news

    def _placed(self, target: Target) -> bool:
        """Return whether the frame of a target has a pose, or will have one before it."""
        if target.begin is not None:
            return True
        last, coming = self.timeline.newest, self._coming[target.robot, target.kind]
        known = last is not None and (target.robot, target.frame) in last.frames
        return known or any(entry.at <= target.at for entry in coming)

    def _take(self, setting: Setting) -> None:
        """Make a decision."""
        self._revision += 1
        setting = replace(setting, revision=self._revision)
        self.timeline.hear(setting)
        self._news.append(setting)

    def _due(self, stamp: float) -> list[Target]:
        """Return the last target of each robot and kind whose time has come; forget the others."""
        due = []
        for coming in self._coming.values():
            if not coming:
                continue
            count = 0
            while count < len(coming) and coming[count].at <= stamp + ROUNDING:
                count += 1
            if count:
                due.append(coming[count - 1])
                del coming[:count]
        return due
