"""Which robots are on which channel: what requests make of it, and what forbids them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

from lexstack.references import References, combined
from lexstack.tasks.stack import Stack
from lexstack.transition.channels.channel import Channel
from lexstack.transition.requests import SwitchRequest
from lexstack.transition.robot_group import RobotGroup

PartOf = Callable[[Iterable[int]], RobotGroup]
"""Makes the part of some robots, by their places."""


def without(channels: Iterable[Channel], robots: Collection[int], part_of: PartOf) -> list[Channel]:
    """Return what remains of channels when some robots leave them; the others go on as they do."""
    rest = [(each, set(each.part.robots).difference(robots)) for each in channels]
    return [each.of(part_of(kept)) for each, kept in rest if kept]


def as_asked(
    channels: Sequence[Channel],
    requests: Iterable[SwitchRequest],
    stacks: Mapping[str, Stack],
    part_of: PartOf,
) -> list[Channel]:
    """Return the channels as if requests were done, one after another."""
    found = list(channels)
    for request in requests:
        goal = stacks[request.stack].of(request.robots)
        channel = Channel(part_of(request.robots), (goal,), "")
        found = [*without(found, request.robots, part_of), channel]
    return found


def coupling(channels: Iterable[Channel], part: RobotGroup) -> str:
    """Return which task couples robots of a part with others of their channel, in words, or ''."""
    for channel in channels:
        task = channel.target.coupling(part.robots)
        if task:
            others = [name for name in channel.part.names if name not in part.names]
            return (
                f"the task {task!r} of {channel.target.name!r} couples its robots with "
                f"{', '.join(others)}"
            )
    return ""


def references_before(channels: Sequence[Channel], references: References) -> References:
    """Return the references of the tick before, of every robot from its channel.

    ``references`` are for channels that have served no tick.
    """
    first = channels[0].used or references
    if all((channel.used or references) is first for channel in channels):
        return first
    return combined(
        ((channel.part.robots, channel.used or references) for channel in channels), references
    )
