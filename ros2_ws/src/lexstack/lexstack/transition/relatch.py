"""When a blend latches again before its end, and how often: so that it always ends.

Every latch starts alpha at 0. A source that comes and goes, or targets that jump at every tick,
would keep a blend from its end for ever. So both are counted within one blend: after ``LOSSES``
losses the stack solver is not followed again, and after ``TARGETS`` sets of targets further ones
are followed within the acceleration limits, as they are without a switch.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from lexstack.transition.bridge import follows_within
from lexstack.transition.messages import Source
from lexstack.transition.route import Route
from lexstack.transition.sources.inbox import Choice
from lexstack.transition.tick_context import TickContext
from lexstack.types import LinearTask

LOSSES = 3  # of the stack solver in one blend; after the last one it is not followed again
TARGETS = 10  # sets of targets for which one blend begins again
_NEVER = -1_000_000  # a tick long before the first one


@dataclass(frozen=True, slots=True)
class Tally:
    """What one blend has met so far.

    Attributes:
        losses: of the stack solver.
        targets: sets of targets that made it latch.
        counted: the revision of the last ones, -1 where it is not known.
        anew: the last tick at which targets took effect in the controller; ``_NEVER``: none did, or
            they have shown in the source's chi.
        revision: of the references that the followed chi was solved with; None: not known.
    """

    losses: int = 0
    targets: int = 0
    counted: int = -1
    anew: int = _NEVER
    revision: int | None = None

    def lost(self, before: Source, choice: Choice, *, done: bool) -> Tally:
        """Return it after a tick; ``done``: alpha was at 1, so that this begins another blend."""
        if before is not Source.SOLVER or choice.source is Source.SOLVER:
            return self
        return replace(self, losses=1 if done else self.losses + 1)

    def with_target(self, context: TickContext) -> Tally:
        """Return it after a latch for the references of this tick."""
        revision = context.references.revision or -1
        if revision == self.counted != -1:
            return self  # the same targets, still being led in
        return replace(self, targets=self.targets + 1, counted=revision)

    def seen(self) -> Tally:
        """Return it after new targets have shown in the source's chi: no more are expected."""
        return replace(self, anew=_NEVER)

    def may_latch(self, context: TickContext) -> bool:
        """Return whether the references of this tick may make the blend latch."""
        led_in = context.references.revision == self.counted > 0
        return self.targets < TARGETS or led_in

    def at(self, context: TickContext, choice: Choice) -> Tally:
        """Return it with what is known of the references at this tick."""
        if not context.anew and choice.revision == self.revision:
            return self
        anew = context.tick if context.anew else self.anew
        return replace(self, anew=anew, revision=choice.revision)

    def unsteady(self, context: TickContext, choice: Choice, stale: int) -> bool:
        """Return whether a step of the source's chi at this tick may be a new reference's doing.

        If both revisions are known, it is so when the chi has another one than that of the tick
        before. Otherwise targets that took effect a few ticks ago may show in the chi only now.

        Args:
            context: of this tick.
            choice: whom the controller follows.
            stale: the most ticks by which a chi may be late.
        """
        if choice.sample is None:
            return context.anew
        if None not in (choice.revision, self.revision):
            return choice.revision != self.revision
        return context.anew or context.tick - self.anew <= stale


def level_jumps(route: Route, level: tuple[LinearTask, ...], context: TickContext) -> bool:
    """Return whether new references move level 1 by more than the joints follow in one tick.

    Less than that needs no bridge: many small steps must not keep a transition from its end.
    """
    if context.references is context.references_before:
        return False
    old = route.target.first(context.kinematics, context.references_before)
    return not follows_within(level, old, context.reach)
