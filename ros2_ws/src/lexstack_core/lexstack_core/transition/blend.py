"""One blend under way, as a value: latched at its start, advanced once a tick."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lexstack_core.bounds import Bounds, JointLimits
from lexstack_core.config.scenario import TransitionConfig
from lexstack_core.hqp import HqpProblem
from lexstack_core.linear import Vector
from lexstack_core.stack import Stack
from lexstack_core.transition.bridge import Bridge, follows_within, latch, same_level
from lexstack_core.transition.methods import METHODS, View
from lexstack_core.transition.plan import Means
from lexstack_core.transition.profile import alpha
from lexstack_core.transition.request import SwitchRequest
from lexstack_core.transition.sources import Moment
from lexstack_core.transition.status import Source
from lexstack_core.transition.time_optimal import Progress, advanced

_START = Progress()


@dataclass(frozen=True, slots=True)
class Blend:
    """A blend under way.

    Attributes:
        request: that it serves.
        origin: the stack that A comes from.
        target: the stack that A goes to.
        source: whose chi it follows.
        start: the tick at which alpha is 0.
        bridge: the gaps that were latched there.
        source_chi: the source's optimum of this tick, shape (n,).
        progress: alpha of this tick, and its rate where the profile has a state.
    """

    request: SwitchRequest
    origin: Stack
    target: Stack
    source: Source
    start: int
    bridge: Bridge
    source_chi: Vector
    progress: Progress = _START

    @classmethod
    def latched(
        cls,
        request: SwitchRequest,
        stacks: tuple[Stack, Stack],
        source: tuple[Source, Vector],
        moment: Moment,
        before: Blend | None,
    ) -> Blend:
        """Return a blend that starts at this tick: delta and epsilon latched, alpha at 0.

        Args:
            request: to serve.
            stacks: where A comes from and where it goes to.
            source: whom to follow, and its chi of this tick, shape (n,).
            moment: this tick.
            before: the blend that A was in until now, which may have moved level 1.
        """
        origin, target = stacks
        followed = origin if before is None else before.target
        level = target.levels[0].linearise(moment.kinematics, moment.references)
        past = followed.levels[0].linearise(moment.kinematics, moment.before)
        steady = before is None or before.bridge.epsilon is None
        command = moment.kinematics.state.command
        bridge = latch(command, source[1], level, steady and same_level(level, past))
        return cls(request, origin, target, source[0], moment.tick, bridge, source[1])

    def advanced(
        self, chi: Vector, tick: int, config: TransitionConfig, limits: JointLimits, dt: float
    ) -> Blend:
        """Return the blend at a tick, given the source's chi (n,) for it."""
        if config.profile != "time_optimal":
            part = alpha(config.profile, (tick - self.start) * dt, self.request.duration)
            return replace(self, progress=Progress(part), source_chi=chi)
        if tick == self.start:
            return replace(self, source_chi=chi)
        drift = (chi - self.source_chi) / dt
        progress = advanced(self.progress, self.bridge.delta, drift, limits, dt)
        return replace(self, progress=progress, source_chi=chi)

    def level_jumps(self, moment: Moment, bounds: Bounds) -> bool:
        """Return whether new references move level 1 by more than the joints follow in one tick.

        Less than that needs no bridge: a stream of small steps must not hold a transition up.
        """
        if moment.references is moment.before or self.start == moment.tick:
            return False
        new = self.target.levels[0].linearise(moment.kinematics, moment.references)
        old = self.target.levels[0].linearise(moment.kinematics, moment.before)
        return not follows_within(new, old, 0.5 * (bounds.upper - bounds.lower))

    def problem(self, moment: Moment, means: Means) -> HqpProblem:
        """Return what the request's method asks for at this tick."""
        state = (moment.kinematics, moment.references)
        view = View(
            self.target.levels[0].linearise(*state),
            self.source_chi,
            means.bounds,
            means.before,
            new=lambda: self.target.linearise(*state),
            old=lambda: self.origin.linearise(*state),
            free=means.free,
            solve=means.solve,
        )
        return METHODS[self.request.method](view, self.bridge, self.progress.alpha)
