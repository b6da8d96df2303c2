"""The reported state of the robots of one channel, in the words of the message."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from lexstack.hqp import NEAR, NearSingular
from lexstack.transition.channel_problem import Plan
from lexstack.transition.channels.channel import Channel
from lexstack.transition.messages import Phase, Source, TransitionState
from lexstack.transition.requests import SwitchRequest
from lexstack.types import Vector


def with_singularity(state: TransitionState, near: tuple[NearSingular, ...]) -> TransitionState:
    """Return the state of a channel that serves its stack, with its levels near a singularity.

    In the reason, where there is no other one. Without the singular values, which change from tick
    to tick: a reason that stays the same is reported once.
    """
    if not near or state.phase is not Phase.IDLE or state.reason:
        return state
    mine = tuple([f"{name}/" for name in state.robots])
    tasks = [
        f"level {entry.level + 1}: {entry.tasks}"
        for entry in near
        if any(task.startswith(mine) for task in entry.tasks.split(" + "))
    ]
    return replace(state, reason=f"{NEAR}: {', '.join(tasks)}") if tasks else state


def coming(
    channel: Channel, pending: Iterable[SwitchRequest], scheduled: Iterable[SwitchRequest]
) -> tuple[SwitchRequest, Phase] | None:
    """Return the next request that takes robots of a channel, and how far it is."""
    robots = set(channel.group.robots)
    for requests, phase in ((pending, Phase.PREPARING), (scheduled, Phase.REQUESTED)):
        for request in requests:
            if robots.intersection(request.robots):
                return request, phase
    return None


def transition_state(
    channel: Channel,
    plan: Plan,
    chi: Vector,
    next_: tuple[SwitchRequest, Phase] | None,
    *,
    adopts: bool,
) -> TransitionState:
    """Return the state of a channel at a tick.

    Args:
        channel: before it adopts.
        plan: of this tick.
        chi: that was solved, shape (n,).
        next_: the next request for any of its robots, and whether it is requested or preparing.
        adopts: whether the controller adopts the stack at the end.
    """
    blend, names = channel.blend, channel.group.names
    if blend is None:
        id_, stack, phase, alpha = channel.id, channel.target.name, Phase.IDLE, plan.alpha
        origin = channel.origin
        if channel.aborted:
            phase = Phase.ABORTED
        elif next_ is not None:
            request, phase = next_
            # A request leaves the stack in effect, not the one that was left by the last request.
            id_, origin, stack, alpha = request.id, stack, request.stack, 0.0
        return TransitionState(
            id_,
            origin,
            stack,
            Source.NONE,
            "",
            phase,
            alpha,
            0.0,
            0.0,
            channel.aborted or channel.reason,
            names,
        )
    mine = channel.group.columns
    gap = 0.0 if plan.source is None else float(np.abs(chi[mine] - plan.source[mine]).max())
    at_end = plan.alpha >= 1.0 and adopts and not blend.route.target.planned
    phase = Phase.ADOPTING if at_end else Phase.BLENDING
    return TransitionState(
        channel.id,
        channel.origin,
        blend.route.target.name,
        blend.source,
        blend.request.method,
        Phase.ABORTED if channel.aborted else phase,
        plan.alpha,
        blend.duration,
        gap,
        channel.aborted or channel.reason,
        names,
    )
