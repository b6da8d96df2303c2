"""The limits that robots on several channels ask for at one tick, as those of all joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from lexstack.limits.joint_limits import LIMITS, JointLimits
from lexstack.tasks.stack import Stack
from lexstack.transition.channels.channel import Channel
from lexstack.transition.channels.lineup import GroupOf
from lexstack.transition.due import Due
from lexstack.transition.methods import JERK_LIMITED
from lexstack.transition.robot_group import Columns

Requested = tuple[Columns, JointLimits | None, bool]
"""The joints of a channel, the limits of its stack (None: the robots' own), and whether by a method
that keeps jerk limits."""


def of_tick(
    channels: Iterable[Channel], due: Due, stacks: Mapping[str, Stack], group_of: GroupOf
) -> list[Requested]:
    """Return what channels ask for at a tick, as its requests that start leave them."""
    routes = [(channel.group, channel.target, channel.method) for channel in channels]
    for request, _ in due.starting:
        stay = [set(group.robots) - set(request.robots) for group, _, _ in routes]
        routes = [
            (group_of(robots), stack, method)
            for robots, (_, stack, method) in zip(stay, routes, strict=True)
            if robots
        ]
        routes.append((group_of(request.robots), stacks[request.stack], request.method))
    return [
        (group.columns, stack.limits, method in JERK_LIMITED) for group, stack, method in routes
    ]


class RequestedLimits:
    """The requested limits; the same object while nothing changes, as users compare identities."""

    def __init__(self, own: JointLimits, *, always: bool) -> None:
        """Know the robots' own limits, and whether jerk is limited ``always``."""
        self._own = own
        self._always = always
        self._last: tuple[Requested, ...] = ()
        self._limits = own

    def of(self, requested: Sequence[Requested]) -> tuple[JointLimits, bool]:
        """Return the limits of all joints, and whether jerk is limited for any of them.

        Where it is limited on some channels alone, the others have an infinite jerk limit.
        """
        if len(requested) == 1:
            _, limits, jerk = requested[0]
            return limits or self._own, jerk
        jerks = {jerk for _, _, jerk in requested}
        first = requested[0][1]
        if len(jerks) == 1 and all(limits is first for _, limits, _ in requested):
            return first or self._own, True in jerks
        if not self._same(requested):
            self._last, self._limits = tuple(requested), self._put_together(requested, jerks)
        return self._limits, True in jerks

    def _same(self, requested: Sequence[Requested]) -> bool:
        """Return whether all is as it was at the last call."""
        return len(requested) == len(self._last) and all(
            a[0] is b[0] and a[1] is b[1] and a[2] == b[2]
            for a, b in zip(requested, self._last, strict=True)
        )

    def _put_together(self, requested: Sequence[Requested], jerks: set[bool]) -> JointLimits:
        """Return each channel's limits on its joints."""
        values = {name: getattr(self._own, name).copy() for name in LIMITS}
        for columns, limits, jerk in requested:
            for name in LIMITS:
                values[name][columns] = getattr(limits or self._own, name)[columns]
            if len(jerks) == 2 and not jerk and not self._always:
                values["jerk"][columns] = np.inf
        return JointLimits(**values)
