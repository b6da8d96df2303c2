"""One blend under way, as a value: latched at its start, advanced once a tick."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from lexstack.hqp import HqpProblem
from lexstack.transition.bridge import Bridge, latch
from lexstack.transition.gap_motion import GapMotion
from lexstack.transition.latch_state import LatchState
from lexstack.transition.messages import Source
from lexstack.transition.methods import METHODS, View
from lexstack.transition.profiles import PROFILES, TimedProfile, alpha
from lexstack.transition.relatch import Tally
from lexstack.transition.requests import SwitchRequest
from lexstack.transition.robot_group import RobotGroup
from lexstack.transition.route import Route
from lexstack.transition.tick_context import TickContext
from lexstack.transition.time_optimal import FadingGap, Progress
from lexstack.types import LinearTask, Vector

_START = Progress()
_NOTHING = Tally()
# Of the acceleration and the jerk limits: what fading the gap to the own optimum may add.
_LITTLE = (0.007, 0.002)
_SHORTEST = 0.1  # s
# Latches shortly before this one: a target that reaches controller and solver at different ticks
# makes two in all; more are a stream.
_PAIR = 1
_JUMP = 5.0  # of a joint's acceleration limit: more is no acceleration, but a jump of the source
_FELT = 1e-3  # of a joint's acceleration limit: a smaller difference of accelerations is ignored


@dataclass(frozen=True, slots=True, eq=False)
class Blend:
    """A blend under way.

    Attributes:
        way: from which stack to which one, for which request.
        source: whose chi it follows.
        start: the tick at which alpha is 0.
        duration: in which alpha rises to 1 [s].
        bridge: the gaps that were latched there, and what is carried over at this tick.
        source_chi: the source's optimum of this tick, shape (n,).
        step: how far the command would have moved at the start, without the latch, shape (n,).
        carry: the motion of the gap at its latch, None where it has none.
        drift: how far the source's optimum has moved since the tick before, without what new
            targets moved in it, shape (n,).
        progress: alpha of this tick, and its rate where the profile has a state.
        alone: whether the solver is not followed any more in this blend.
        end: the first tick for which the source is no longer needed, None until it is known.
        recent: how many latches came shortly before this one.
        tally: of losses and sets of targets within this blend.
    """

    way: Route
    source: Source
    start: int
    duration: float
    bridge: Bridge
    source_chi: Vector
    step: Vector
    carry: GapMotion | None = None
    drift: Vector | None = None
    progress: Progress = _START
    alone: bool = False
    end: int | None = None
    recent: int = 0
    tally: Tally = _NOTHING

    @property
    def request(self) -> SwitchRequest:
        """The request that it serves."""
        return self.way.request

    @classmethod
    def latched(
        cls,
        way: Route,
        source: tuple[Source, Vector],
        level: tuple[LinearTask, ...],
        past: LatchState,
        context: TickContext,
    ) -> Blend:
        """Return a blend that starts at this tick: delta and epsilon latched, alpha at 0.

        Args:
            way: from which stack to which one.
            source: whom to follow, and its chi of this tick, shape (n,).
            level: level 1 of the target at this tick.
            past: how the robots would go on without the latch.
            context: of this tick.
        """
        bridge = latch(past.start, source[1], level, past.level_goes_on)
        if past.gap_motion is not None and past.gap_motion.older:
            # A slip of an earlier latch keeps its own fading time; delta is the rest of the gap.
            fading = past.gap_motion.at(0.0)
            bridge = replace(bridge, delta=bridge.delta - fading, motion=fading)
        step = past.start - context.kinematics.state.command
        return cls(
            way,
            source[0],
            context.tick,
            way.request.duration,
            bridge,
            source[1],
            step,
            past.gap_motion,
            recent=past.recent,
        )

    def taken_over(self, own: Vector, tick: int, context: TickContext) -> Blend:
        """Return the blend from the solver's chi of this tick to the own optimum, shape (n,).

        If the solver's chi is late or frozen, adopting the stack at once would make the command
        jump by their difference. It fades so slowly that it adds little acceleration and jerk
        (``_LITTLE``), and at most in the time of the blend before: a chi that is one tick old takes
        the shortest time. A later latch, as for a new target, has the request's whole time again.
        """
        gap = self.source_chi - own
        step = np.zeros_like(own) if self.drift is None else self.drift
        return Blend(
            self.way,
            Source.LOCAL,
            tick,
            self._unfelt(gap, context),
            Bridge(gap, None),
            own,
            step,
            alone=True,
            tally=self.tally,
        )

    def _unfelt(self, gap: Vector, context: TickContext) -> float:
        """Return in which time [s] a gap (n,) fades with ``_LITTLE`` acceleration and jerk.

        The quintic's first and second derivative are at most 1.875 / T and 5.774 / T^2.
        """
        mine, limits = self.way.group.columns, context.limits
        size = np.abs(gap[mine])
        by_rate = 1.875 * float((size / limits.acceleration[mine]).max()) / _LITTLE[0]
        by_jerk = math.sqrt(5.774 * float((size / limits.jerk[mine]).max()) / _LITTLE[1])
        return min(self.duration, max(_SHORTEST, by_rate, by_jerk))

    def of(self, part: RobotGroup) -> Blend:
        """Return the blend of some of its robots, unchanged otherwise."""
        way = self.way.of(part)
        target = self.way.target
        epsilon, tasks = self.bridge.epsilon, () if target.planned else target.levels[0].tasks
        if epsilon is not None:
            kept = [set(task.robots) <= set(part.robots) for task in tasks]
            epsilon = tuple(gap for gap, mine in zip(epsilon, kept, strict=True) if mine)
        return replace(self, way=way, bridge=replace(self.bridge, epsilon=epsilon))

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
        carry, bridge = self.carry, self.bridge
        if tick == self.start + 1 and self.recent <= _PAIR and not unsteady:
            carry = self._with_slip(drift, context)
        if carry is not None:
            bridge = replace(bridge, motion=carry.at(elapsed))
        known = self.drift if unsteady else drift
        # Not by dataclasses.replace, which takes three times as long.
        latched = (self.way, self.source, self.start, self.duration, bridge, chi, self.step)
        rest = (self.alone, self.end, self.recent, self.tally)
        return Blend(*latched, carry, known, progress, *rest)

    def jumps(self, chi: Vector, context: TickContext) -> bool:
        """Return whether the source's chi (n,) moves by more than the joints follow in one tick.

        Its motion of the tick before, where that is known, is taken off first. A plan never counts
        as a jump.
        """
        if self.way.target.planned:
            return False
        mine, moved = self.way.group.columns, chi - self.source_chi
        jump = moved if self.drift is None else moved - self.drift
        return bool((np.abs(jump[mine]) > context.reach[mine]).any())

    def over_at(self, tick: int, context: TickContext) -> bool:
        """Return whether alpha is 1 at the next tick, if the source stays where it is."""
        if self._timed is None:
            return self.advanced(self.source_chi, tick, context).progress.alpha >= 1.0
        return self._timed.alpha((tick - self.start) * context.dt, self.duration) >= 1.0

    def left(
        self, tick: int, duration: float, context: TickContext
    ) -> tuple[Vector, GapMotion | None]:
        """Return what this blend, given up at ``tick``, leaves to the next one of ``duration`` [s].

        In a blend the command follows chi(t) = chi_S(t) + d(t), with the source's optimum chi_S and
        the gap d(t) = (1 - alpha) delta + what ``carry`` adds. The next blend begins with the step
        that this would have made now, so that the velocity goes on as it was, and with the rate and
        the second derivative of d, so that the gap's part of the acceleration does. The source's
        part is known one tick later (``_with_slip``).

        Returns:
            How far the command would have moved since the tick before, shape (n,), and the motion
            of the gap, None where it has none to keep.
        """
        if tick == self.start:  # given up before it began: there is no tick before to compare with
            return self.step, None if self.carry is None else replace(self.carry, duration=duration)
        # The source's part of the step. Its chi of this tick may be the very jump that ends this
        # blend, so it is taken to move as it did in the tick before.
        step = np.zeros_like(self.step) if self.drift is None else self.drift
        carry = None
        # Without a d(t) that is known ahead nothing is kept: the next blend begins from rest.
        if self._timed is not None:
            times = tuple((tick + k - self.start) * context.dt for k in (-1, 0, 1))
            # The gap's part of the step, with all that is in the gap.
            step = step + self._gap(times[1]) - self._gap(times[0])
            # d' and d'' by central differences over one tick to either side,
            #     d' = (d(t + dt) - d(t - dt)) / (2 dt)
            #     d'' = (d(t + dt) - 2 d(t) + d(t - dt)) / dt^2,
            # without the slips. These go on to fade beside the new gap, in their own short time
            # (``older``): in d'' their curvature would be led to rest in the whole duration, and
            # drive the command far off, farther with every latch.
            before, now, after = (self._lasting_gap(time) for time in times)
            speed, bend = (after - before) / (2.0 * context.dt), (after - 2.0 * now + before)
            older = () if self.carry is None else self.carry.fading(times[1])
            carry = GapMotion(speed, bend / context.dt**2, duration, older=older)
        # A step beyond the acceleration limit is no motion that the command could have made.
        reach = context.limits.acceleration * context.dt
        return np.minimum(np.maximum(step, -reach), reach), carry

    def problem(self, level: tuple[LinearTask, ...], context: TickContext) -> HqpProblem:
        """Return what the request's method asks for at this tick; ``level`` is the new level 1."""
        state = (context.kinematics, context.references)
        way = self.way
        view = View(
            way.group,
            level,
            self.source_chi,
            new=lambda: self._new(context),
            old=lambda: way.origin.linearise(*state),
            context=context,
        )
        return METHODS[self.request.method](view, self.bridge, self.progress.alpha)

    def _new(self, context: TickContext) -> tuple[tuple[LinearTask, ...], ...]:
        """Return all levels of the target stack; of a planned one only to follow the plan."""
        way = self.way
        if way.target.planned:
            return (way.group.follow(self.source_chi),)
        return way.target.linearise(context.kinematics, context.references)

    @property
    def _timed(self) -> TimedProfile | None:
        """The profile, where its alpha is known ahead."""
        profile = PROFILES[self.request.profile]
        return profile if isinstance(profile, TimedProfile) else None

    def _fading(self, drift: Vector, context: TickContext) -> FadingGap:
        """Return the gap of the robots that are on their way, and their limits."""
        mine, limits = self.way.group.columns, context.limits
        motion = self.bridge.delta[mine], drift[mine] / context.dt
        return FadingGap(*motion, limits.acceleration[mine], limits.jerk[mine], context.dt)

    def _gap(self, elapsed: float) -> Vector:
        """Return the gap after ``elapsed`` seconds, shape (n,)."""
        gap = (1.0 - alpha(self.request.profile, elapsed, self.duration)) * self.bridge.delta
        return gap if self.carry is None else gap + self.carry.at(max(elapsed, 0.0))

    def _lasting_gap(self, elapsed: float) -> Vector:
        """Return the gap after ``elapsed`` seconds without the slips, shape (n,)."""
        gap = (1.0 - alpha(self.request.profile, elapsed, self.duration)) * self.bridge.delta
        return gap if self.carry is None else gap + self.carry.lasting(max(elapsed, 0.0))

    def _with_slip(self, drift: Vector, context: TickContext) -> GapMotion | None:
        """Return the motion of the gap, now that the source's step from tick to tick is known."""
        if self._timed is None:
            return None
        # At the latch the command moved by ``step``, and the source now moves by ``drift``: over dt
        # their difference is the gap's rate. What ``carry`` has of it already is taken off.
        slip = (self.step - drift) / context.dt
        carry, limit = self.carry, context.limits.acceleration
        if carry is not None:
            slip -= (
                (carry.at(context.dt) - carry.at(0.0)) / context.dt if carry.older else carry.rate
            )
        # Joint by joint, so that robots do not affect each other. At most the acceleration limit; a
        # difference far beyond it is no acceleration, but a jump of the source, and counts as none.
        size = np.abs(slip)
        np.minimum(np.maximum(slip, -limit), limit, out=slip)
        slip[(size <= _FELT * limit) | (size > _JUMP * limit)] = 0.0
        if not slip[self.way.group.columns].any():
            return carry
        return replace(
            carry or GapMotion.none(slip.size, self.duration), acceleration_mismatch=slip
        )
