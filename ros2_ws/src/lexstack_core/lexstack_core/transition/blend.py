"""One blend under way, as a value: latched at its start, advanced once a tick."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lexstack_core.hqp import HqpProblem
from lexstack_core.linear import LinearTask, Vector
from lexstack_core.stack import Stack
from lexstack_core.transition.bridge import Bridge, follows_within, goes_on, latch
from lexstack_core.transition.carry import Carry
from lexstack_core.transition.methods import METHODS, View
from lexstack_core.transition.plan import Means
from lexstack_core.transition.profile import alpha
from lexstack_core.transition.request import SwitchRequest
from lexstack_core.transition.sources import Moment
from lexstack_core.transition.status import Source
from lexstack_core.transition.time_optimal import Progress, advanced

_START = Progress()
_FELT = 1e-3  # of a joint's acceleration limit: no difference of accelerations below it is felt


@dataclass(frozen=True, slots=True, eq=False)
class Blend:
    """A blend under way.

    Attributes:
        request: that it serves.
        origin: the stack that A comes from.
        target: the stack that A goes to.
        source: whose chi it follows.
        start: the tick at which alpha is 0.
        bridge: the gaps that were latched there, and what is carried over at this tick.
        source_chi: the source's optimum of this tick, shape (n,).
        heading: A's acceleration without what made it latch, shape (n,), m/s^2 and rad/s^2.
        carry: the motion of the gap at its latch, None where it has none.
        drift: how far the source's optimum has moved since the tick before, shape (n,).
        progress: alpha of this tick, and its rate where the profile has a state.
        takes_over: whether it leads from B's chi at the end to A's own, and so away from B.
    """

    request: SwitchRequest
    origin: Stack
    target: Stack
    source: Source
    start: int
    bridge: Bridge
    source_chi: Vector
    heading: Vector
    carry: Carry | None = None
    drift: Vector | None = None
    progress: Progress = _START
    takes_over: bool = False

    @classmethod
    def latched(
        cls,
        request: SwitchRequest,
        stacks: tuple[Stack, Stack],
        source: tuple[Source, Vector],
        moment: Moment,
        before: Blend | None,
        means: Means,
    ) -> Blend:
        """Return a blend that starts at this tick: delta and epsilon latched, alpha at 0.

        Args:
            request: to serve.
            stacks: where A comes from and where it goes to.
            source: whom to follow, and its chi of this tick, shape (n,).
            moment: this tick.
            before: the blend that A was in until now, which may have moved level 1.
            means: what the controller lends.
        """
        origin, target = stacks
        kinematics, references = moment.kinematics, moment.references
        followed = origin if before is None else before.target
        level = target.levels[0].linearise(kinematics, references)
        past = followed.levels[0].linearise(kinematics, moment.before)
        same = goes_on(level, past, means.reach)
        command, carry = kinematics.state.command, None
        if before is None:
            # What A would have sent without the switch: its motion then goes on as it was, where
            # the last command would stand still for a tick.
            levels = origin.linearise(kinematics, references if same else moment.before)
            start = means.solve(HqpProblem(levels, means.bounds))
        else:
            step, carry = before.left(moment.tick, request.duration, means)
            start = command + step
            same = same and before.bridge.epsilon is None
        bridge = latch(start, source[1], level, same)
        heading = (start - command) / means.dt
        blend = cls(request, origin, target, source[0], moment.tick, bridge, source[1], heading)
        # A new request looks at B again.
        over = before is not None and before.takes_over and before.request is request
        return replace(blend, carry=carry, takes_over=over)

    def taken_over(self, own: Vector, tick: int, dt: float) -> Blend:
        """Return the blend from B's chi of this tick on to A's own optimum of it, shape (n,).

        Where B's chi is late or frozen, adopting the stack at once would make the command jump by
        their difference.
        """
        bridge = Bridge(self.source_chi - own, None)
        heading = np.zeros_like(own) if self.drift is None else self.drift / dt
        stacks = (self.origin, self.target)
        blend = Blend(self.request, *stacks, Source.LOCAL, tick, bridge, own, heading)
        return replace(blend, takes_over=True)

    def advanced(self, chi: Vector, tick: int, means: Means) -> Blend:
        """Return the blend at a tick, given the source's chi (n,) for it."""
        if tick == self.start:
            return replace(self, source_chi=chi)
        drift, elapsed = chi - self.source_chi, (tick - self.start) * means.dt
        if self.request.profile == "time_optimal":
            progress = advanced(
                self.progress, self.bridge.delta, drift / means.dt, means.limits, means.dt
            )
        else:
            progress = Progress(alpha(self.request.profile, elapsed, self.request.duration))
        carry, bridge = self.carry, self.bridge
        if tick == self.start + 1:
            carry = self._with_slip(drift / means.dt, means)
        if carry is not None:
            bridge = replace(bridge, carried=carry.at(elapsed))
        return replace(
            self, source_chi=chi, drift=drift, progress=progress, carry=carry, bridge=bridge
        )

    def left(self, tick: int, duration: float, means: Means) -> tuple[Vector, Carry | None]:
        """Return what this blend, given up at ``tick``, leaves to the next one of ``duration`` [s].

        Returns:
            How far the command would have moved since the tick before, shape (n,), and the motion
            of the gap.
        """
        step = np.zeros_like(self.heading) if self.drift is None else self.drift
        carry = None
        if self.request.profile != "time_optimal":
            before, now, after = (self._gap((tick + k - self.start) * means.dt) for k in (-1, 0, 1))
            step = step + now - before
            speed, bend = (after - before) / (2.0 * means.dt), (after - 2.0 * now + before)
            carry = Carry(speed, bend / means.dt**2, duration)
        reach = means.limits.acceleration * means.dt
        return np.minimum(np.maximum(step, -reach), reach), carry

    def level_jumps(self, level: tuple[LinearTask, ...], moment: Moment, means: Means) -> bool:
        """Return whether new references move level 1 by more than the joints follow in one tick.

        Less than that needs no bridge: a stream of small steps must not hold a transition up.
        """
        if moment.references is moment.before or self.start == moment.tick:
            return False
        old = self.target.levels[0].linearise(moment.kinematics, moment.before)
        return not follows_within(level, old, means.reach)

    def problem(self, level: tuple[LinearTask, ...], moment: Moment, means: Means) -> HqpProblem:
        """Return what the request's method asks for at this tick; ``level`` is the new level 1."""
        state = (moment.kinematics, moment.references)
        view = View(
            level,
            self.source_chi,
            means.bounds,
            means.before,
            new=lambda: self.target.linearise(*state),
            old=lambda: self.origin.linearise(*state),
            free=means.free,
            solve=means.solve,
        )
        return METHODS[self.request.method](view, self.bridge, self.progress.alpha)

    def _gap(self, elapsed: float) -> Vector:
        """Return the gap after ``elapsed`` seconds, shape (n,)."""
        request = self.request
        gap = (1.0 - alpha(request.profile, elapsed, request.duration)) * self.bridge.delta
        return gap if self.carry is None else gap + self.carry.at(max(elapsed, 0.0))

    def _with_slip(self, acceleration: Vector, means: Means) -> Carry | None:
        """Return the motion of the gap, now that the source's acceleration (n,) is known."""
        if self.request.profile == "time_optimal":
            return None
        slip = self.heading - acceleration
        carry = self.carry
        if carry is not None:
            slip = slip - carry.speed
        limit = means.limits.acceleration
        if (np.abs(slip) <= _FELT * limit).all():
            return carry
        slip = np.minimum(np.maximum(slip, -limit), limit)
        if carry is None:
            none = np.zeros_like(slip)
            carry = Carry(none, none, self.request.duration)
        return replace(carry, slip=slip)
