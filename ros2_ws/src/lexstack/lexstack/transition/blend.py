"""One blend under way, as a value: latched at its start, advanced once a tick."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lexstack.hqp import HqpProblem
from lexstack.transition.bridge import Bridge, latch
from lexstack.transition.gap_motion import GapMotion, with_mismatch
from lexstack.transition.latch_state import LatchState
from lexstack.transition.messages import Source
from lexstack.transition.methods import METHODS, View
from lexstack.transition.profiles import PROFILES, TimedProfile
from lexstack.transition.relatch import Tally
from lexstack.transition.requests import SwitchRequest
from lexstack.transition.robot_group import RobotGroup
from lexstack.transition.route import Route
from lexstack.transition.tick_context import TickContext
from lexstack.transition.time_optimal import FadingGap, Progress
from lexstack.types import LinearTask, Vector

_START = Progress()
_NOTHING = Tally()
# Latches shortly before this one: a target that reaches controller and solver at different ticks
# makes two in all; more are a stream.
_PAIR = 1


@dataclass(frozen=True, slots=True, eq=False)
class Blend:
    """A blend under way.

    Attributes:
        route: from which stack to which one, for which request.
        source: whose chi it follows.
        start: the tick at which alpha is 0.
        duration: in which alpha rises to 1 [s].
        bridge: the gaps that were latched there, and what is carried over at this tick.
        source_chi: the source's optimum of this tick, shape (n,).
        step: how far the command would have moved at the start, without the latch, shape (n,).
        gap_motion: the motion of the gap at its latch, None where it has none.
        drift: how far the source's optimum has moved since the tick before, without what new
            targets moved in it, shape (n,).
        progress: alpha of this tick, and its rate where the profile has a state.
        alone: whether the solver is not followed any more in this blend.
        end: the first tick for which the source is no longer needed, None until it is known.
        recent: how many latches came shortly before this one.
        tally: of losses and sets of targets within this blend.
    """

    route: Route
    source: Source
    start: int
    duration: float
    bridge: Bridge
    source_chi: Vector
    step: Vector
    gap_motion: GapMotion | None = None
    drift: Vector | None = None
    progress: Progress = _START
    alone: bool = False
    end: int | None = None
    recent: int = 0
    tally: Tally = _NOTHING

    @property
    def request(self) -> SwitchRequest:
        """The request that it serves."""
        return self.route.request

    @property
    def timed(self) -> TimedProfile | None:
        """The profile, where its alpha is known ahead."""
        profile = PROFILES[self.request.profile]
        return profile if isinstance(profile, TimedProfile) else None

    @classmethod
    def latched(
        cls,
        route: Route,
        source: tuple[Source, Vector],
        level: tuple[LinearTask, ...],
        latch_state: LatchState,
        context: TickContext,
    ) -> Blend:
        """Return a blend that starts at this tick: delta and epsilon latched, alpha at 0.

        Args:
            route: from which stack to which one.
            source: whom to follow, and its chi of this tick, shape (n,).
            level: level 1 of the target at this tick.
            latch_state: how the robots would go on without the latch.
            context: of this tick.
        """
        bridge = latch(latch_state.start, source[1], level, latch_state.level_goes_on)
        if latch_state.gap_motion is not None and latch_state.gap_motion.older:
            # A slip of an earlier latch keeps its own fading time; delta is the rest of the gap.
            fading = latch_state.gap_motion.at(0.0)
            bridge = replace(bridge, delta=bridge.delta - fading, motion=fading)
        step = latch_state.start - context.kinematics.state.command
        return cls(
            route,
            source[0],
            context.tick,
            route.request.duration,
            bridge,
            source[1],
            step,
            latch_state.gap_motion,
            recent=latch_state.recent,
        )

    def of(self, group: RobotGroup) -> Blend:
        """Return the blend of some of its robots, unchanged otherwise."""
        route = self.route.of(group)
        target = self.route.target
        epsilon, tasks = self.bridge.epsilon, () if target.planned else target.levels[0].tasks
        if epsilon is not None:
            kept = [set(task.robots) <= set(group.robots) for task in tasks]
            epsilon = tuple(gap for gap, mine in zip(epsilon, kept, strict=True) if mine)
        return replace(self, route=route, bridge=replace(self.bridge, epsilon=epsilon))

    def advanced(
        self, chi: Vector, tick: int, context: TickContext, *, unsteady: bool = False
    ) -> Blend:
        """Return the blend at a tick, given the source's chi (n,) for it.

        ``unsteady``: that chi may have jumped by a new reference, which is no motion to carry over.
        """
        if tick == self.start:
            return replace(self, source_chi=chi)
        drift, elapsed = chi - self.source_chi, (tick - self.start) * context.dt
        progress = PROFILES[self.request.profile].advanced(
            self.progress, elapsed, self.duration, lambda: self._fading(drift, context)
        )
        gap_motion, bridge = self.gap_motion, self.bridge
        if tick == self.start + 1 and self.recent <= _PAIR and not unsteady:
            gap_motion = None
            if self.timed is not None:
                moved, mine = self.step - drift, self.route.group.columns
                gap_motion = with_mismatch(self.gap_motion, moved, mine, self.duration, context)
        if gap_motion is not None:
            bridge = Bridge(bridge.delta, bridge.epsilon, gap_motion.at(elapsed))
        known = self.drift if unsteady else drift
        # Not by dataclasses.replace, which takes three times as long.
        latched = (self.route, self.source, self.start, self.duration, bridge, chi, self.step)
        rest = (self.alone, self.end, self.recent, self.tally)
        return Blend(*latched, gap_motion, known, progress, *rest)

    def jumps(self, chi: Vector, context: TickContext) -> bool:
        """Return whether the source's chi (n,) moves by more than the joints follow in one tick.

        Its motion of the tick before, where that is known, is taken off first. A plan never counts
        as a jump.
        """
        if self.route.target.planned:
            return False
        mine, moved = self.route.group.columns, chi - self.source_chi
        jump = moved if self.drift is None else moved - self.drift
        return bool((np.abs(jump[mine]) > context.reach[mine]).any())

    def over_at(self, tick: int, context: TickContext) -> bool:
        """Return whether alpha is 1 at the next tick, if the source stays where it is."""
        if self.timed is None:
            return self.advanced(self.source_chi, tick, context).progress.alpha >= 1.0
        return self.timed.alpha((tick - self.start) * context.dt, self.duration) >= 1.0

    def problem(self, level: tuple[LinearTask, ...], context: TickContext) -> HqpProblem:
        """Return what the request's method asks for at this tick; ``level`` is the new level 1."""
        state = (context.kinematics, context.references)
        route = self.route
        view = View(
            route.group,
            level,
            self.source_chi,
            new=lambda: self._new(context),
            old=lambda: route.origin.linearise(*state),
            context=context,
        )
        return METHODS[self.request.method](view, self.bridge, self.progress.alpha)

    def _new(self, context: TickContext) -> tuple[tuple[LinearTask, ...], ...]:
        """Return all levels of the target stack; of a planned one only to follow the plan."""
        route = self.route
        if route.target.planned:
            return (route.group.follow(self.source_chi),)
        return route.target.linearise(context.kinematics, context.references)

    def _fading(self, drift: Vector, context: TickContext) -> FadingGap:
        """Return the gap of the robots that are on their way, and their limits."""
        mine, limits = self.route.group.columns, context.limits
        motion = self.bridge.delta[mine], drift[mine] / context.dt
        return FadingGap(*motion, limits.acceleration[mine], limits.jerk[mine], context.dt)
