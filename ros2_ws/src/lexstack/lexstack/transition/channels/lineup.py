"""Which robots are on which channel: what requests make of it, and what forbids them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from lexstack.options import shown
from lexstack.references import References, combined
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
    """Return the places of ``robots`` that are to go to a stack, and why they cannot, or ''.

    ``moved`` are the names of all robots that the stack moves.
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


def cancelled(
    channels: Sequence[Channel], dropped: Sequence[SwitchRequest]
) -> tuple[tuple[Channel, ...], tuple[Stack, ...], str, str] | None:
    """Return what is given up with all blends and with requests; None: there is nothing.

    Returns:
        The channels, of which those concerned report it once; the stacks to go back to, of the
        blends; the reason of that; and what is cancelled, in words.
    """
    blends = [channel for channel in channels if channel.blend is not None]
    if not dropped and not blends:
        return None
    gone = dict.fromkeys(channel.id for channel in blends)
    gone = gone or dict.fromkeys(request.id for request in dropped[-3:])
    plural = "s" if len(gone) > 1 else ""
    what = f"transition{plural} {', '.join(map(str, gone))}"
    if not blends and len(dropped) > len(gone):
        what = f"{len(dropped)} transitions, the last of them {', '.join(map(str, gone))},"
    why = f"{what} {'were' if plural else 'was'} cancelled"
    told = tuple(
        replace(each, aborted=why) if each.blend is not None or not blends else each
        for each in channels
    )
    back = tuple(stack for channel in blends for stack in channel.adopted)
    return told, back, f"{why}; going back", f"{what} {'are' if plural else 'is'} cancelled"


def references_before(channels: Sequence[Channel], references: References) -> References:
    """Return the references of the tick before, of every robot from its channel.

    ``references`` are for channels that have served no tick.
    """
    first = channels[0].used or references
    if all((channel.used or references) is first for channel in channels):
        return first
    return combined(
        ((channel.group.robots, channel.used or references) for channel in channels), references
    )
