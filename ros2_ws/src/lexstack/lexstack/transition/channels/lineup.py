"""Which robots are on which channel: what requests make of it, and what forbids them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

from lexstack.options import shown
from lexstack.references import References
from lexstack.robots import Team
from lexstack.tasks.stack import Stack
from lexstack.transition.channels.channel import Channel
from lexstack.transition.requests import SwitchRequest
from lexstack.transition.robot_group import RobotGroup

GroupOf = Callable[[Iterable[int]], RobotGroup]
"""Makes the group of some robots, by their places."""


def without(
    channels: Iterable[Channel], robots: Collection[int], group_of: GroupOf
) -> list[Channel]:
    """Return what remains of channels when some robots leave them; the others go on as they do."""
    rest = [(each, set(each.group.robots).difference(robots)) for each in channels]
    return [each.of(group_of(kept)) for each, kept in rest if kept]


def as_requested(
    channels: Sequence[Channel],
    requests: Iterable[SwitchRequest],
    stacks: Mapping[str, Stack],
    group_of: GroupOf,
) -> list[Channel]:
    """Return the channels as if requests were done, one after another."""
    found = list(channels)
    for request in requests:
        goal = stacks[request.stack].of(request.robots)
        channel = Channel(group_of(request.robots), (goal,), "")
        found = [*without(found, request.robots, group_of), channel]
    return found


def coupling(channels: Iterable[Channel], group: RobotGroup) -> str:
    """Return which task couples robots of a group with others of their channel, in words, or ''."""
    for channel in channels:
        task = group.shares(channel.group) and channel.target.coupling(group.robots)
        if task:
            others = [name for name in channel.group.names if name not in group.names]
            return (
                f"the task {task!r} of {channel.target.name!r} couples its robots with "
                f"{', '.join(others)}"
            )
    return ""


def some_of(
    stack: Stack, robots: Collection[str], moved: Collection[str], team: Team
) -> tuple[tuple[int, ...], str]:
    """Return the places of robots that are to go to a stack, and why they cannot, or ''.

    Args:
        stack: where to.
        robots: their names.
        moved: names of all robots that the stack moves.
        team: that they belong to.
    """
    strangers = [name for name in robots if name not in moved]
    if strangers:
        known = ", ".join(moved)
        return (), f"stack {stack.name!r} does not move {shown(strangers[0])}, but {known}"
    if len(set(robots)) < len(robots):
        return (), "robots: a name stands in it twice"
    some = tuple(sorted({team.index(name) for name in robots}))
    task = stack.coupling(some)
    return some, f"the task {task!r} of {stack.name!r} couples more robots" if task else ""


def references_before(channels: Sequence[Channel], references: References) -> References:
    """Return the references of the tick before, of every robot from its channel.

    ``references`` are for channels that have served no tick.
    """
    first = channels[0].used or references
    if all((channel.used or references) is first for channel in channels):
        return first
    ee, base, revisions = list(references.ee), list(references.base), []
    for channel in channels:
        used = channel.used or references
        for robot in channel.group.robots:
            ee[robot], base[robot] = used.ee[robot], used.base[robot]
        revisions.append(used.revision)
    return References(tuple(ee), tuple(base), max(revisions))
