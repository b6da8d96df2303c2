"""Some robots that share a stack, or switch to one together: a value, advanced once a tick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lexstack.hqp import NEAR, HqpProblem
from lexstack.references import References
from lexstack.tasks.stack import Stack, joined
from lexstack.transition.blend import Blend
from lexstack.transition.blend_end import at_end, left_by
from lexstack.transition.bridge import goes_on
from lexstack.transition.channel_problem import Plan
from lexstack.transition.gap_motion import GapMotion
from lexstack.transition.held_back import at_velocity_limit, held_back
from lexstack.transition.latch_state import HURRY, LatchState
from lexstack.transition.messages import Source
from lexstack.transition.methods import BRIDGES
from lexstack.transition.relatch import LOSSES, level_jumps
from lexstack.transition.robot_group import RobotGroup
from lexstack.transition.sources.inbox import Choice, Sources
from lexstack.transition.tick_context import TickContext
from lexstack.types import LinearTask, Vector

_NEAR = 10.0  # of what a joint follows in one tick: as old as a plan may be, and two ticks more
_LOOK = 10  # ticks from look to look whether the velocity limits hold the target's levels back


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """Robots with one alpha; every robot is on one channel.

    Attributes:
        group: the robots.
        adopted: the stacks that they adopted last; one, but in a blend that brought them together.
        id: of the last transition, 0 before the first.
        origin: name of the stack that they came from.
        used: the references of the tick before.
        blend: under way, None when they serve their stack.
        reason: why it is so, where it is not as asked.
        aborted: why the last transition was given up, to be reported once.
    """

    group: RobotGroup
    adopted: tuple[Stack, ...]
    origin: str
    id: int = 0
    used: References | None = None
    blend: Blend | None = None
    reason: str = ""
    aborted: str = ""

    @property
    def target(self) -> Stack:
        """The stack in effect; during a blend the one that they go to."""
        if self.blend is not None:
            return self.blend.route.target
        return self.adopted[0] if len(self.adopted) == 1 else joined(self.adopted, self.group.team)

    @property
    def method(self) -> str:
        """The method of the transition under way, '' without one."""
        return "" if self.blend is None else self.blend.request.method

    def of(self, group: RobotGroup) -> Channel:
        """Return the channel of some of its robots; whatever is under way goes on."""
        if group.robots == self.group.robots:
            return self
        mine = [
            stack.of(tuple(robot for robot in stack.robots or () if robot in group.robots))
            for stack in self.adopted
        ]
        adopted = tuple(stack for stack in mine if stack.robots)
        blend = None if self.blend is None else self.blend.of(group)
        return replace(self, group=group, adopted=adopted, blend=blend)

    # ---- the tick

    def step(self, context: TickContext, sources: Sources, *, adopts: bool) -> tuple[Channel, Plan]:
        """Return what is solved for these robots at this tick, and the channel after it."""
        if self.blend is None:
            levels = self.target.linearise(context.kinematics, context.references)
            plan = Plan(HqpProblem(levels, context.bounds), None, 1.0)
            used = context.references
            return (self if self.used is used else replace(self, used=used)), plan
        return self._go_on(self.blend, context, sources, adopts=adopts)

    def _go_on(
        self, blend: Blend, context: TickContext, sources: Sources, *, adopts: bool
    ) -> tuple[Channel, Plan]:
        """Return what is solved in a blend; latch again where the source or level 1 changed."""
        target, tick = blend.route.target, context.tick
        adopts = adopts and not target.planned
        level = target.first(context.kinematics, context.references)
        choice, blend = _followed(blend, level, context, sources)
        reason = choice.why or self.reason
        chi = sources.chi(choice, target, context)
        unsteady = blend.tally.unsteady(context, choice, sources.stale)
        blend = self._latched_again(blend, (choice, chi), level, context, unsteady=unsteady)
        tally = blend.tally.at(context, choice)
        if tally is not blend.tally:
            blend = replace(blend, tally=tally)
        blend = blend.advanced(chi, tick, context, unsteady=unsteady)
        ends = adopts and choice.source is Source.SOLVER and blend.progress.alpha >= 1.0
        if ends and blend.request.method in BRIDGES:
            blend, why = at_end(blend, sources.own(target, context), tick, context)
            reason = why or reason
        elif adopts and blend.end is None and blend.over_at(tick + 1, context):
            # Known one tick ahead, so that the source never solves for nothing.
            blend = replace(blend, end=tick + 2)
        if NEAR not in reason and not (tick - blend.start) % _LOOK:
            why = _held_back(blend, context)
            reason = "; ".join(word for word in (reason, why) if word)
        plan = Plan(blend.problem(level, context), blend.source_chi, blend.progress.alpha)
        used, kept = context.references, (self.group, self.adopted, self.origin, self.id)
        return Channel(*kept, used, blend, reason, self.aborted), plan

    def _latched_again(
        self,
        blend: Blend,
        source: tuple[Choice, Vector],
        level: tuple[LinearTask, ...],
        context: TickContext,
        *,
        unsteady: bool,
    ) -> Blend:
        """Return the blend, latched again where its target has changed.

        Args:
            blend: under way.
            source: whom to follow, and its chi of this tick, shape (n,).
            level: level 1 of the target at this tick.
            context: of this tick.
            unsteady: whether the chi may have moved by a new reference.
        """
        (choice, chi), tally = source, blend.tally
        if choice.source is blend.source:
            if blend.start == context.tick or not tally.may_latch(context):
                return blend
            jumps = unsteady and blend.jumps(chi, context)
            if not jumps and not level_jumps(blend.route, level, context):
                return blend
            tally = tally.with_target(context)
            tally = tally.seen() if jumps else tally
        latch_state = latch_state_of((self,), level, blend.request.duration, context)
        if choice.source is Source.HTMPC and self._begins_here(chi, context):
            latch_state = LatchState(chi, latch_state.level_goes_on, None)
        latched = Blend.latched(blend.route, (choice.source, chi), level, latch_state, context)
        # A source that stays is assumed to move as before, until its step is known; not for ever.
        drift = blend.drift if choice.source is blend.source and not latch_state.recent else None
        return replace(latched, drift=drift, alone=blend.alone, tally=tally)

    def _begins_here(self, chi: Vector, context: TickContext) -> bool:
        """Return whether a plan that is back begins where these robots are, at chi (n,) now.

        Then there is no gap to fade. One that was latched would come back with every plan, as each
        begins at the command.
        """
        gap = np.abs(chi - context.kinematics.state.command) <= _NEAR * context.reach
        return bool(gap[self.group.columns].all())

    def finished(self, plan: Plan, sources: Sources, *, adopts: bool) -> Channel:
        """Return the channel after the tick: at the end it has adopted the stack."""
        blend = self.blend
        if blend is None or plan.alpha < 1.0 or not adopts or blend.route.target.planned:
            return replace(self, aborted="") if self.aborted else self
        target, aborted = blend.route.target, ""
        if blend.source is Source.MINIMUM_VELOCITY:
            target, aborted = sources.at_rest(target), f"{self.reason}; at rest"
        reported = (
            blend.alone and not blend.tally.losses
        )  # of the blend to the own optimum, now over
        reason = "" if reported else self.reason
        return replace(self, adopted=(target,), blend=None, aborted=aborted, reason=reason)


def _followed(
    blend: Blend, level: tuple[LinearTask, ...], context: TickContext, sources: Sources
) -> tuple[Choice, Blend]:
    """Return whom a blend follows at this tick, and the blend with a loss of the solver counted."""
    if blend.alone:
        return Choice(blend.source), blend
    # The solver reports the residual of the whole stack: that of a part cannot be compared.
    known = level if blend.route.whole else ()
    expected = source_of(blend.route.target)
    choice = sources.present(blend.source, blend.request.id, context, known, expected)
    done = blend.progress.alpha >= 1.0
    tally = blend.tally.lost(blend.source, choice, done=done)
    if tally is blend.tally:
        return choice, blend
    alone = tally.losses >= LOSSES
    if alone:
        count = f"; it is loss {tally.losses} of this blend, so the solver is not followed again"
        choice = replace(choice, why=choice.why + count)
    return choice, replace(blend, tally=tally, alone=alone)


def _held_back(blend: Blend, context: TickContext) -> str:
    """Return which level of the target asks for more than the velocity limits allow, or ''."""
    target, group = blend.route.target, blend.route.group
    velocity = context.limits.velocity
    if target.planned or not at_velocity_limit(group, blend.source_chi, velocity):
        return ""
    return held_back(group, target.linearise(context.kinematics, context.references), velocity)


def source_of(stack: Stack) -> Source:
    """Return who is to solve a stack for the controller."""
    return Source.HTMPC if stack.planned else Source.SOLVER


def latch_state_of(
    channels: Sequence[Channel],
    level: tuple[LinearTask, ...],
    duration: float,
    context: TickContext,
) -> LatchState:
    """Return the latch state of robots that were on one channel or on several.

    Without a blend it is the optimum of the stack at this tick: the motion then goes on as it was,
    where the last command would keep its velocity for a tick. In a blend it is the last command,
    moved on by the step that the blend would have made.

    Args:
        channels: that the robots were on; no others are on them.
        level: level 1 of the target stack at this tick.
        duration: of the blend to come [s].
        context: of this tick.
    """
    kinematics = context.kinematics
    old = tuple(
        task
        for channel in channels
        for task in channel.target.first(kinematics, context.references_before)
    )
    same = goes_on(level, old, context.reach)
    references = context.references if same else context.references_before
    start = kinematics.state.command.copy()
    gap_motion: GapMotion | None = None
    recent = 0
    for channel in channels:
        columns = channel.group.columns
        if channel.blend is None:
            levels = channel.target.linearise(kinematics, references)
            chi = context.solve(HqpProblem(levels, context.bounds))
            start[columns] = chi[columns]
            continue
        same = same and channel.blend.bridge.epsilon is None
        if (context.tick - channel.blend.start) * context.dt < HURRY:
            recent = max(recent, channel.blend.recent + 1)
        step, left = left_by(channel.blend, context.tick, duration, context)
        start[columns] += step[columns]
        if left is not None:
            gap_motion = gap_motion or GapMotion.none(start.size, duration)
            gap_motion = gap_motion.with_columns(columns, left)
    return LatchState(start, same, gap_motion, recent)
