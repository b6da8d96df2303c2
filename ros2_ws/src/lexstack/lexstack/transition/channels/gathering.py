"""Channels that become one: by a request for robots of several, or on the same stack again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lexstack.tasks.stack import Stack, joined
from lexstack.transition.blend import Blend
from lexstack.transition.channels.channel import Channel, latch_state_of
from lexstack.transition.channels.lineup import GroupOf, references_before, without
from lexstack.transition.relatch import Tally
from lexstack.transition.requests import SwitchRequest
from lexstack.transition.robot_group import RobotGroup
from lexstack.transition.route import Route
from lexstack.transition.sources.inbox import Choice, Sources
from lexstack.transition.tick_context import TickContext
from lexstack.types import Vector


def begin(
    channels: Sequence[Channel],
    starting: tuple[SwitchRequest, Choice],
    stacks: Mapping[str, Stack],
    sources: Sources,
    group_of: GroupOf,
    context: TickContext,
) -> tuple[Channel, ...]:
    """Return the channels with a request's robots in a new one, in a blend.

    ``starting`` is the request and whom to follow, the other values are the controller's.
    """
    request, first = starting
    group = group_of(request.robots)
    concerned = [each for each in channels if group.shares(each.group)]
    inside = [each.of(group_of(set(each.group.robots) & set(group.robots))) for each in concerned]
    target = stacks[request.stack].of(group.robots)
    references = context.references
    context = context.between(references_before(inside, references), references)
    whole = target is stacks[request.stack]
    level = target.first(context.kinematics, references) if whole else ()
    choice = sources.checked(first, context, level)
    chi = sources.chi(choice, target, context)
    channel = _begun(inside, request, (group, target, whole), (choice, chi), context)
    others = without(channels, group.robots, group_of)
    return tuple(sorted([*others, channel], key=lambda each: each.group.robots))


def _begun(
    channels: Sequence[Channel],
    request: SwitchRequest,
    goal: tuple[RobotGroup, Stack, bool],
    source: tuple[Choice, Vector],
    context: TickContext,
) -> Channel:
    """Return the channel that a request makes of robots that were on others until now.

    Args:
        channels: that they were on, without any other robots.
        request: whose tick has come.
        goal: the robots, the stack that they go to, and whether they are all that it moves.
        source: whom to follow, and its chi of this tick, shape (n,).
        context: of this tick.
    """
    (group, target, whole), (choice, chi) = goal, source
    level = target.first(context.kinematics, context.references)
    latch_state = latch_state_of(channels, level, request.duration, context)
    route = Route(request, group, joined([c.target for c in channels], group.team), target, whole)
    blend = Blend.latched(route, (choice.source, chi), level, latch_state, context)
    blend = replace(blend, tally=Tally().at(context, choice))
    gone = dict.fromkeys(c.blend.request.id for c in channels if c.blend is not None)
    reason = request.reason
    if gone and not reason:
        reason = f"pre-empted transition {', '.join(map(str, gone))}"
    adopted = tuple(stack for channel in channels for stack in channel.adopted)
    return Channel(
        group,
        adopted,
        " + ".join(dict.fromkeys(stack.name for stack in adopted)),
        request.id,
        context.references,
        blend,
        "; ".join(word for word in (reason, choice.why) if word),
        next((channel.aborted for channel in channels if channel.aborted), ""),
    )


def together(channels: Sequence[Channel], group_of: GroupOf) -> tuple[Channel, ...]:
    """Return the channels with those made one that serve the same stack alone.

    Args:
        channels: in the order of their robots.
        group_of: makes the group of some robots.
    """
    idle: dict[tuple[str, int], list[Channel]] = {}
    for channel in channels:
        if channel.blend is None and not channel.aborted:
            idle.setdefault((channel.target.name, id(channel.used)), []).append(channel)
    shared = [same for same in idle.values() if len(same) > 1]
    if not shared:
        return tuple(channels)
    kept = [each for each in channels if not any(each in same for same in shared)]
    for same in shared:
        newest = max(same, key=lambda each: each.id)
        group = group_of(robot for each in same for robot in each.group.robots)
        stack = joined([each.target for each in same], group.team)
        kept.append(replace(newest, group=group, adopted=(stack,)))
    return tuple(sorted(kept, key=lambda each: each.group.robots))
