"""Robot A's transition from stack to stack: who is followed, since when, and what comes next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lexstack_core.config.scenario import ScenarioConfig
from lexstack_core.hqp import HqpProblem
from lexstack_core.linear import Vector
from lexstack_core.model import Kinematics
from lexstack_core.references import References
from lexstack_core.stack import Stack
from lexstack_core.transition.blend import Blend
from lexstack_core.transition.methods import BRIDGES, METHODS
from lexstack_core.transition.plan import Means, Plan
from lexstack_core.transition.request import Answer, RequestBook, SwitchRequest
from lexstack_core.transition.sources import LocalSource, Moment, Sources
from lexstack_core.transition.status import (
    Announcement,
    Phase,
    Source,
    SourceSample,
    TransitionState,
)

_SAME = 1e-3  # of what a joint's acceleration limit allows in one tick: no difference that is felt


class Transition:
    """The transition of one controller; ``step`` before its solve, ``finish`` after it."""

    def __init__(
        self, stacks: Mapping[str, Stack], local: LocalSource, scenario: ScenarioConfig
    ) -> None:
        """Start idle on the scenario's initial stack.

        Args:
            stacks: every stack that may be asked for, by name.
            local: what A follows where robot B is lost.
            scenario: rate, mode, transition and timeouts.
        """
        self._stacks = stacks
        self._sources = Sources(local, scenario)
        self._book = RequestBook(stacks, METHODS, scenario.transition)
        self._config = scenario.transition
        self._adopts = scenario.transition.at_end == "adopt"
        self._lockstep = scenario.mode == "lockstep"
        self._dt = 1.0 / scenario.rate
        self._stack = stacks[scenario.initial_stack]
        self._blend: Blend | None = None
        self._pending: SwitchRequest | None = None
        self._used: References | None = None
        self._tick = 0
        self._id = 0
        self._from = self._stack.name
        self._reason = ""
        self._aborted = ""
        self._outbox: list[Announcement] = []

    @property
    def target(self) -> Stack:
        """The stack in effect; during a blend the one that A goes to."""
        return self._stack if self._blend is None else self._blend.target

    def governing(self, tick: int) -> tuple[Stack, str]:
        """Return the stack that this tick serves or goes to, and by what method ('': by none)."""
        due = self._book.peek(tick) or self._pending
        if due is not None and self._sources.first(due.id, due.at_tick, tick) is not None:
            return self._stacks[due.stack], due.method
        return self.target, "" if self._blend is None else self._blend.request.method

    # ---- what comes in between two ticks

    def ask(self, stack: str, duration: float, method: str, at_tick: int) -> Answer:
        """Return the answer to a request to switch; see RequestBook.ask."""
        return self._ask(stack, duration, method, at_tick, "")

    def set_defaults(self, duration: float, method: str) -> None:
        """Change what an empty duration [s] and method stand for; see RequestBook."""
        self._book.set_defaults(duration, method)

    def request(self, stack: str) -> Answer:
        """Ask as configured, for those who hear no answer: a refusal stands in the state."""
        answer = self._ask(stack, 0.0, "", 0, "")
        if not answer.accepted:
            self._reason = f"refused: {answer.message}"
        return answer

    def cancel(self) -> Answer:
        """Give up the transition under way and those scheduled, and go back smoothly."""
        blend, dropped = self._blend, self._drop_coming()
        if not dropped and blend is None:
            return Answer(False, "there is no transition to cancel")
        gone = blend.request.id if blend is not None else dropped[-1].id
        self._aborted = f"transition {gone} was cancelled"
        if blend is None:
            return Answer(True, f"transition {gone} is cancelled before it began")
        answer = self._ask(self._stack.name, 0.0, "", 0, f"{self._aborted}; going back")
        return replace(answer, message=f"transition {gone} is cancelled; {answer.message}")

    def end(self) -> None:
        """Let the source forget all that was asked of it: this transition is not used further."""
        self._drop_coming()
        if self._blend is not None:
            self._withdraw(self._blend.request)

    def hear(self, sample: SourceSample) -> None:
        """Take the source's newest chi."""
        self._sources.hear(sample)

    def awaits(self, tick: int) -> bool:
        """Return whether this tick needs a chi of the source that is not there yet (lockstep)."""
        if not self._lockstep:
            return False
        due = self._book.peek(tick) or self._pending
        if due is not None:
            return self._sources.fresh(due.id, tick) is None
        blend = self._blend
        if blend is None or blend.takes_over:
            return False
        if self._sources.fresh(blend.request.id, tick) is not None:
            return False
        # Once lost, B is waited for again only after it has been heard again.
        return blend.source is Source.ROBOT_B or self._sources.answered_since(
            blend.request.id, blend.start
        )

    def take_announcements(self) -> list[Announcement]:
        """Return what the source must be told, once."""
        taken, self._outbox = self._outbox, []
        return taken

    # ---- the tick

    def step(self, kinematics: Kinematics, references: References, means: Means) -> Plan:
        """Return what A solves at this tick, with what the controller lends.

        While the source's first solution for a new stack is awaited, A goes on with what it did,
        with the references of before: they change together with the stack.
        """
        self._tick = kinematics.state.tick
        before = self._used or references
        self._pending = self._book.due(self._tick) or self._pending
        if self._pending is not None:
            level = self._stacks[self._pending.stack].levels[0].linearise(kinematics, references)
            first = self._sources.first(self._pending.id, self._pending.at_tick, self._tick, level)
            if first is None:
                references = before
            else:
                self._begin(self._pending, *first, Moment(kinematics, references, before), means)
        self._used = references
        if self._blend is None:
            levels = self._stack.linearise(kinematics, references)
            return Plan(HqpProblem(levels, means.bounds), None, 1.0)
        return self._go_on(self._blend, Moment(kinematics, references, before), means)

    def finish(self, plan: Plan, chi: Vector) -> TransitionState:
        """Return what to tell of this tick, after ``chi`` (n,) was solved; adopt at the end."""
        gap = 0.0 if plan.source is None else float(np.max(np.abs(chi - plan.source)))
        told = self._told(plan.alpha, gap)
        self._aborted = ""
        if self._blend is not None and plan.alpha >= 1.0 and self._adopts:
            self._adopt(self._blend)
        return told

    # ---- inside

    def _ask(self, stack: str, duration: float, method: str, at_tick: int, reason: str) -> Answer:
        answer = self._book.ask(stack, duration, method, at_tick, self._tick, reason)
        if answer.request is not None:
            self._announce(answer.request)
        return answer

    def _announce(self, request: SwitchRequest) -> None:
        """Let the source solve a request's stack from its tick on."""
        announcement = Announcement(request.id, request.stack, request.at_tick, active=True)
        self._outbox.append(announcement)

    def _withdraw(self, request: SwitchRequest, from_tick: int = 0) -> None:
        """Let the source forget a request, at once or from a tick on."""
        self._outbox.append(Announcement(request.id, request.stack, from_tick, active=False))

    def _drop_coming(self) -> list[SwitchRequest]:
        """Forget the requests that have not begun, and return them."""
        dropped = [*self._book.scheduled, *([self._pending] if self._pending else [])]
        self._book.clear()
        self._pending = None
        for request in dropped:
            self._withdraw(request)
        return dropped

    def _begin(
        self, request: SwitchRequest, source: Source, why: str, moment: Moment, means: Means
    ) -> None:
        """Start to follow: the pending request becomes the blend under way."""
        reason = request.reason
        if self._blend is not None:
            self._withdraw(self._blend.request)
            reason = reason or f"pre-empted transition {self._blend.request.id}"
        self._reason = "; ".join(part for part in (reason, why) if part)
        self._id, self._from, self._pending = request.id, self._stack.name, None
        chi = self._sources.chi(source, request.id, request.stack, moment)
        stacks = (self.target, self._stacks[request.stack])
        self._blend = Blend.latched(request, stacks, (source, chi), moment, self._blend, means)

    def _go_on(self, blend: Blend, moment: Moment, means: Means) -> Plan:
        """Return what A solves in a blend; latch anew where the source or level 1 changed."""
        request, source = blend.request, blend.source
        level = blend.target.levels[0].linearise(moment.kinematics, moment.references)
        if not blend.takes_over:
            source, why = self._sources.present(blend.source, request.id, moment.tick, level)
            self._reason = why or self._reason
        chi = self._sources.chi(source, request.id, request.stack, moment)
        if source is not blend.source or blend.level_jumps(level, moment, means):
            stacks = (blend.origin, blend.target)
            blend = Blend.latched(request, stacks, (source, chi), moment, blend, means)
            if not blend.takes_over:
                self._announce(request)  # the end that it was told is no longer right
        blend = blend.advanced(chi, moment.tick, means)
        if self._adopts and source is Source.ROBOT_B:
            if blend.progress.alpha >= 1.0:
                blend = self._taken_over(blend, moment, means)
            elif blend.advanced(chi, moment.tick + 1, means).progress.alpha >= 1.0:
                # Told one tick ahead, so that the source never solves for nothing.
                self._withdraw(request, from_tick=moment.tick + 2)
        self._blend = blend
        problem = blend.problem(level, moment, means)
        return Plan(problem, blend.source_chi, blend.progress.alpha)

    def _taken_over(self, blend: Blend, moment: Moment, means: Means) -> Blend:
        """Return how A goes on at the end: as it is where its own optimum is B's, else to it."""
        request = blend.request
        if request.method not in BRIDGES:
            return blend
        own = self._sources.chi(Source.LOCAL, request.id, request.stack, moment)
        apart = np.abs(own - blend.source_chi)
        if (apart <= _SAME * means.limits.acceleration * self._dt).all():
            return blend
        self._reason = (
            f"robot B's chi at tick {moment.tick} is {apart.max():.2g} off robot A's own: "
            "robot A blends on to its own"
        )
        return blend.taken_over(own, moment.tick, self._dt)

    def _adopt(self, blend: Blend) -> None:
        """Take the new stack over; the source may rest."""
        self._stack = blend.target
        if blend.source is Source.MINIMUM_VELOCITY:
            self._stack = self._sources.at_rest(blend.request.stack)
            self._aborted = f"{self._reason}; at rest"
        self._blend = None

    def _told(self, part: float, gap: float) -> TransitionState:
        """Return the state of this tick in the words of the message."""
        blend, pending = self._blend, self._pending
        state = TransitionState(
            self._id,
            self._from,
            self.target.name,
            Source.NONE if blend is None else blend.source,
            "" if blend is None else blend.request.method,
            Phase.IDLE,
            part,
            0.0 if blend is None else blend.request.duration,
            gap,
            self._reason,
        )
        if self._aborted:
            return replace(state, phase=Phase.ABORTED, reason=self._aborted)
        if blend is not None:
            at_end = part >= 1.0 and self._adopts
            return replace(state, phase=Phase.ADOPTING if at_end else Phase.BLENDING)
        coming = pending or (self._book.scheduled[0] if self._book.scheduled else None)
        if coming is None:
            return state
        phase = Phase.REQUESTED if pending is None else Phase.PREPARING
        return replace(state, id=coming.id, to_stack=coming.stack, phase=phase, alpha=0.0)
