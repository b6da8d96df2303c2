"""What is heard on /tf and /tf_static, kept for a while: a tree of frames that anybody may publish.

tf2_ros has no wheel, and its C++ none either; this is the part of it that targets need.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, Generic, TypeVar

import numpy as np

from lexstack.errors import InputError
from lexstack.references import POSES
from lexstack.robots import Pose
from lexstack_ros.messages.conversions import to_placement, to_seconds

T = TypeVar("T")

KEPT = 10.0
"""How long transforms are kept [s], as in tf2."""
_MOST_FRAMES = 1000
_ROUNDING = 1e-9  # s, of stamps
_STALE = 1.0  # s, older than simulated time: "the newest" is then no answer


_HERE = Pose(np.zeros(3), np.eye(3))


class EarlyError(InputError):
    """A pose is asked for at a time that is still to come."""

    def __init__(self, text: str, ahead: float) -> None:
        """Say by how much [s] the time is ahead of what is known."""
        super().__init__(text)
        self.ahead = ahead


class History(Generic[T]):
    """What was at increasing times, for as long as it is kept."""

    def __init__(self) -> None:
        """Start with nothing."""
        self._times: deque[float] = deque()
        self._values: deque[T] = deque()

    @property
    def newest(self) -> float | None:
        """The last time [s]."""
        return self._times[-1] if self._times else None

    @property
    def last(self) -> T | None:
        """What was at the last time."""
        return self._values[-1] if self._values else None

    def add(self, time: float, value: T) -> None:
        """Take what was at a time [s]; one of before the last begins anew, as after a reset."""
        times, values = self._times, self._values
        if times and time <= times[-1]:
            if time == times[-1]:
                values[-1] = value
                return
            times.clear()
            values.clear()
        times.append(time)
        values.append(value)
        while times[-1] - times[0] > KEPT:
            times.popleft()
            values.popleft()

    def around(self, stamp: float, what: str) -> tuple[T, T, float]:
        """Return what was before and after a time [s], and its share of the way from one to other.

        Stamp 0 means the newest.

        Raises:
            EarlyError: the time is still to come.
            InputError: the time is no longer kept, or nothing is.
        """
        if not self._times:
            raise InputError(f"{what} is not known: nothing was heard yet")
        oldest, newest = self._times[0], self._times[-1]
        if not stamp or abs(stamp - newest) < _ROUNDING:
            return self._values[-1], self._values[-1], 0.0
        if stamp > newest:
            raise EarlyError(
                f"{what} at {stamp:.3f} s is not known yet, the newest is of {newest:.3f} s; "
                "stamp 0 means the newest",
                stamp - newest,
            )
        if stamp < oldest - _ROUNDING:
            raise InputError(
                f"{what} at {stamp:.3f} s is not known any more, the oldest is of {oldest:.3f} s"
            )
        k = max(bisect_left(self._times, stamp - _ROUNDING), 0)
        later, earlier = self._values[k], self._values[max(k - 1, 0)]
        if self._times[k] - stamp < _ROUNDING:
            return later, later, 0.0
        share = (stamp - self._times[k - 1]) / (self._times[k] - self._times[k - 1])
        return earlier, later, share


def between(one: Pose, other: Pose, share: float) -> Pose:
    """Return the pose a share of the way from one to another."""
    return POSES.moved(one, share * POSES.gap(one, other)) if share else one


def after(first: Pose, then: Pose) -> Pose:
    """Return a pose that is told in another one, in the frame of that."""
    return Pose(
        first.position + first.rotation @ then.position,
        np.asarray(first.rotation @ then.rotation),
    )


class Transforms:
    """The tree of what was heard.

    Attributes:
        refused: transforms that were none.
    """

    def __init__(self) -> None:
        """Start with nothing."""
        self.refused = 0
        self._moving: dict[
            str, tuple[str, History[Pose]]
        ] = {}  # by frame: its parent, and where it was
        self._static: dict[str, tuple[str, Pose]] = {}

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames whose parents were heard."""
        return tuple(sorted({*self._moving, *self._static}))

    def hear(self, transforms: Iterable[Any], *, static: bool = False) -> None:
        """Take the transforms of a message."""
        for entry in transforms:
            child, parent = entry.child_frame_id.lstrip("/"), entry.header.frame_id.lstrip("/")
            transform = entry.transform
            try:
                pose = to_placement(transform.translation, transform.rotation, child)
            except InputError:
                self.refused += 1
                continue
            full = len(self._moving) + len(self._static) >= _MOST_FRAMES
            if not child or child == parent or (full and child not in self.frames):
                self.refused += 1
            elif static:
                self._static[child] = parent, pose
            else:
                known = self._moving.get(child)
                history = History[Pose]() if known is None or known[0] != parent else known[1]
                history.add(to_seconds(entry.header.stamp), pose)
                self._moving[child] = parent, history

    def find(
        self, frame: str, stamp: float, now: float, root: Callable[[str], Pose | None]
    ) -> Pose | None:
        """Return the pose of a frame in the world, or None: it is in no tree that ends there.

        Args:
            frame: its name.
            stamp: when [s]; 0: as of the newest transforms, which must not be old.
            now: simulated time [s].
            root: returns the pose of a frame that is known otherwise, or None.

        Raises:
            InputError: the time is not known; ``EarlyError`` where it is to come.
        """
        pose, seen = _HERE, {frame}
        while True:
            known = root(frame)
            if known is not None:
                return after(known, pose)
            link = self._link(frame, stamp, now)
            if link is None or link[0] in seen:
                return None
            frame = link[0]
            pose = after(link[1], pose)
            seen.add(frame)

    def chain(self, frame: str) -> list[str]:
        """Return a frame and all above it, from below, to the last one that was heard of."""
        found = [frame]
        while True:
            known = self._static.get(frame) or self._moving.get(frame)
            if known is None or known[0] in found:
                return found
            frame = known[0]
            found.append(frame)

    def newest(self, frame: str, parent: str) -> tuple[float, Pose] | None:
        """Return the pose of a frame in another one above it at the newest time of all between.

        Returns:
            the time [s], 0 where nothing between them moves, and the pose; None: it is not known.
        """
        chain = self.chain(frame)
        if parent not in chain:
            return None
        between_them = chain[: chain.index(parent)]
        times = [
            self._moving[each][1].newest or 0.0 for each in between_them if each not in self._static
        ]
        stamp = min(times, default=0.0)
        try:
            pose = self.find(frame, stamp, stamp, lambda each: _HERE if each == parent else None)
        except InputError:  # of one the others' newest time is over, or still to come
            return None
        return None if pose is None else (stamp, pose)

    def _link(self, frame: str, stamp: float, now: float) -> tuple[str, Pose] | None:
        """Return the parent of a frame and where it is in it; None: it was not heard of."""
        if frame in self._static:
            return self._static[frame]
        if frame not in self._moving:
            return None
        parent, history = self._moving[frame]
        newest = history.newest or 0.0
        if not stamp and abs(now - newest) > _STALE:
            raise InputError(
                f"the newest transform of {frame!r} on /tf is of {newest:.3f} s, simulated time "
                f"is {now:.3f} s"
            )
        return parent, between(*history.around(stamp, f"the transform of {frame!r} on /tf"))
