"""Whose chi the controller follows: the stack solver's while it is fresh, else a substitute's."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lexstack.hqp import Solution
from lexstack.references import References
from lexstack.robots import Kinematics
from lexstack.tasks.stack import Stack
from lexstack.transition.messages import Source, SourceSample
from lexstack.transition.options import TransitionOptions
from lexstack.transition.sources.newest_chi import Inbox
from lexstack.transition.sources.residual_check import ResidualCheck, Rows
from lexstack.transition.tick_context import TickContext
from lexstack.types import Vector

_EVIDENCE = 10  # chi in a row that miss level 1, in realtime


class LocalSource(Protocol):
    """The controller's own substitute for the stack solver."""

    def solve(self, stack: Stack, kinematics: Kinematics, references: References) -> Solution:
        """Return the optimum of a stack, its chi of shape (n,); a failure is a value."""
        ...

    def at_rest(self, stack: Stack) -> Stack:
        """Return level 1 of a stack with minimum velocity below it."""
        ...


@dataclass(frozen=True, slots=True)
class Choice:
    """Whom the controller follows at a tick.

    Attributes:
        source: whose chi.
        why: the reason where it is not who was followed before, else ''.
        sample: the chi of the stack solver or the MPC; None where the controller makes its own.
    """

    source: Source
    why: str = ""
    sample: SourceSample | None = None

    @property
    def revision(self) -> int | None:
        """Of the references that the chi was solved with; None: not known."""
        return None if self.sample is None else self.sample.revision


class Sources:
    """The samples of the stack solver and the MPC, and what replaces them when they are lost."""

    def __init__(self, local: LocalSource, options: TransitionOptions) -> None:
        """Take the substitute, and from the options when a source counts as lost."""
        self._local = local
        self._lost = Source(options.switch.on_loss)
        self._inbox = Inbox()
        # In lockstep the wait has happened, outside, before a tick is served.
        self._lockstep = lockstep = options.lockstep
        self._patience = 0 if lockstep else options.patience
        self.stale = 0 if lockstep else options.stale
        """The most ticks by which a source's chi may be late."""
        self._residual_check = ResidualCheck(self.stale, 1 if lockstep else _EVIDENCE)

    def hear(self, sample: SourceSample) -> None:
        """Take a chi of a source; the newest by its tick counts, whenever it arrives."""
        self._inbox.put(sample)

    def keep(self, transition_ids: Collection[int]) -> None:
        """Forget all other transitions."""
        self._inbox.keep(transition_ids)
        self._residual_check.keep(transition_ids)

    def fresh(
        self, transition_id: int, tick: int, revision: int | None = None
    ) -> SourceSample | None:
        """Return the source's chi for a transition if it is new enough for this tick, else None.

        Args:
            transition_id: of the request that it answers.
            tick: the present one.
            revision: of the references in effect at this tick; None: not known. In lockstep a chi
                with another one is not of this tick; in realtime it is as old as its tick says.
        """
        heard = self._inbox.newest(transition_id, tick)
        if heard is None or not heard.solved or tick - heard.tick > self.stale:
            return None
        if self._lockstep and None not in (revision, heard.revision):
            return heard if heard.revision == revision else None
        return heard

    def answered_since(self, transition_id: int, tick: int, revision: int | None = None) -> bool:
        """Return whether the source has solved for a transition at a later tick than this one.

        With other references than the ``revision`` in effect it has not: whoever answers with wrong
        ones would be waited for at every tick.
        """
        return self._inbox.solved_since(transition_id, tick, revision)

    def first(
        self,
        transition_id: int,
        requested_at: int,
        tick: int,
        revision: int | None = None,
        expected: Source = Source.SOLVER,
    ) -> Choice | None:
        """Return whom to follow into a new stack, or None while the wait goes on.

        Args:
            transition_id: of the request.
            requested_at: the tick for which it was asked.
            tick: the present one.
            revision: of the references in effect; None: not known.
            expected: who is to solve the stack.
        """
        sample = self.fresh(transition_id, tick, revision)
        if sample is not None:
            return Choice(expected, "", sample)
        if tick - requested_at >= self._patience:
            instead = _instead(self._lost, expected)
            return Choice(self._lost, f"{expected.called} sent no chi by tick {tick}: {instead}")
        return None

    def checked(self, first: Choice, context: TickContext, level: Rows) -> Choice:
        """Return the first choice, or the substitute if the chi is not of the tick that it names.

        ``level`` is level 1 of the new stack at this tick; empty: there is nothing to compare with.
        """
        if first.sample is None:
            return first
        revision = context.references.revision
        miss = self._residual_check.miss(first.sample, context.tick, level, revision=revision)
        return Choice(self._lost, _wrong(context.tick, miss, self._lost)) if miss else first

    def present(
        self,
        source: Source,
        transition_id: int,
        context: TickContext,
        level: Rows,
        expected: Source = Source.SOLVER,
    ) -> Choice:
        """Return whom to follow now.

        ``level`` is level 1 of the new stack at this tick, ``expected`` who is to solve it.
        """
        tick, changed = context.tick, source is not expected
        revision = context.references.revision
        sample = self.fresh(transition_id, tick, revision)
        if sample is not None:
            miss = self._residual_check.miss(
                sample, tick, level, anew=context.anew, revision=revision
            )
            if not miss:
                back = f"{expected.called} is back at tick {tick}" if changed else ""
                return Choice(expected, back, sample)
            lost = Choice(self._lost, _wrong(tick, miss, self._lost))
            return Choice(source) if changed else lost
        if changed:
            return Choice(source)
        heard = self._inbox.newest(transition_id, tick)
        last = "nothing" if heard is None else f"tick {heard.tick}"
        if heard is not None and revision and heard.revision not in (None, revision):
            last += f" with references {heard.revision} in place of {revision}"
        instead = _instead(self._lost, expected)
        lost_at = f"{expected.called} lost at tick {tick}, last heard {last}: {instead}"
        return Choice(self._lost, lost_at)

    def chi(self, choice: Choice, stack: Stack, context: TickContext) -> Vector:
        """Return the chi of who is followed at this tick, shape (n,)."""
        if choice.sample is not None:
            return choice.sample.chi
        if choice.source is Source.LOCAL:
            return self.own(stack, context)
        return np.zeros_like(context.kinematics.state.command)

    def own(self, stack: Stack, context: TickContext) -> Vector:
        """Return the controller's own optimum of a stack, shape (n,).

        Where it cannot be solved, the last command is held, and the context reports it.
        """
        solution = self._local.solve(stack, context.kinematics, context.references)
        reason = "" if solution.solved else solution.reason
        return context.held(f"stack {stack.name!r}: {reason}") if reason else solution.chi

    def at_rest(self, stack: Stack) -> Stack:
        """Return the stack that is adopted once the command has come to minimum velocity."""
        return self._local.at_rest(stack)


def _wrong(tick: int, miss: float, instead: Source) -> str:
    """Return the reason to report for a chi that is not of the tick that it names."""
    return f"the solver's chi at tick {tick} misses level 1 by {miss:.2g}: {_instead(instead)}"


def _instead(source: Source, expected: Source = Source.SOLVER) -> str:
    """Return what is followed in place of the source that was asked, in words."""
    if expected is Source.HTMPC:
        return "the robots come to rest"
    if source is Source.LOCAL:
        return "the controller solves the new stack itself"
    return "the controller goes to minimum velocity"
