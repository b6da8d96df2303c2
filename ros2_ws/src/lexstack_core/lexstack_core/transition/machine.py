"""Robot A's transition from stack to stack: who is followed, since when, and what comes next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from lexstack_core.config.scenario import ScenarioConfig
from lexstack_core.linear import LinearTask, Vector
from lexstack_core.model import Kinematics
from lexstack_core.references import References
from lexstack_core.stack import Stack
from lexstack_core.transition.bridge import Bridge, bridged, latch, same_level
from lexstack_core.transition.local import LocalSource
from lexstack_core.transition.profile import alpha
from lexstack_core.transition.request import Answer, RequestBook, SwitchRequest
from lexstack_core.transition.status import (
    Announcement,
    Phase,
    Source,
    SourceSample,
    TransitionState,
)


@dataclass(frozen=True, slots=True)
class Plan:
    """What A solves at one tick.

    Attributes:
        levels: highest first.
        source: the chi that A goes to, shape (n,), or None when it serves its own stack.
        alpha: of the blend, 1 when there is none.
    """

    levels: tuple[tuple[LinearTask, ...], ...]
    source: Vector | None
    alpha: float


@dataclass(frozen=True, slots=True)
class _Follow:
    """A blend under way."""

    request: SwitchRequest
    source: Source
    start: int  # the tick at which alpha is 0
    bridge: Bridge


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
        self._local = local
        self._dt = 1.0 / scenario.rate
        self._config = scenario.transition
        timeouts = scenario.timeouts
        self._lockstep = scenario.mode == "lockstep"
        # In lockstep the wait has happened, on the wall's clock, before a tick is served.
        self._stale = 0 if self._lockstep else round(timeouts.source_stale * scenario.rate)
        self._patience = 0 if self._lockstep else round(timeouts.source_patience * scenario.rate)
        self._book = RequestBook(stacks, scenario.transition)
        self._stack = stacks[scenario.initial_stack]
        self._follow: _Follow | None = None
        self._pending: SwitchRequest | None = None
        self._heard: SourceSample | None = None
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
        return self._stack if self._follow is None else self._stacks[self._follow.request.stack]

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
        dropped = [*self._book.scheduled, *([self._pending] if self._pending else [])]
        follow = self._follow
        if not dropped and follow is None:
            return Answer(False, "there is no transition to cancel")
        self._book.clear()
        self._pending = None
        for request in dropped:
            self._announce(request, active=False)
        gone = follow.request.id if follow is not None else dropped[-1].id
        self._aborted = f"transition {gone} was cancelled"
        if follow is None:
            return Answer(True, f"transition {gone} is cancelled before it began")
        answer = self._ask(self._stack.name, 0.0, "", 0, f"{self._aborted}; going back")
        return replace(answer, message=f"transition {gone} is cancelled; {answer.message}")

    def hear(self, sample: SourceSample) -> None:
        """Take the source's newest chi."""
        self._heard = sample

    def awaits(self, tick: int) -> bool:
        """Return whether this tick needs a chi of the source that is not there yet (lockstep)."""
        if not self._lockstep:
            return False
        due = self._book.peek(tick) or self._pending
        if due is not None:
            return self._fresh(due.id, tick) is None
        follow = self._follow
        if follow is None or self._fresh(follow.request.id, tick) is not None:
            return False
        return follow.source is Source.ROBOT_B or self._is_back(follow)

    def take_announcements(self) -> list[Announcement]:
        """Return what the source must be told, once."""
        taken, self._outbox = self._outbox, []
        return taken

    # ---- the tick

    def step(self, kinematics: Kinematics, references: References) -> Plan:
        """Return what A solves at this tick.

        While the source's first solution for a new stack is awaited, A goes on with what it did,
        with the references of before: they change together with the stack.
        """
        self._tick = kinematics.state.tick
        due = self._book.due(self._tick)
        if due is not None:
            self._pending = due
        if self._used is None:
            self._used = references
        if self._pending is not None:
            source = self._first_source(self._pending)
            if source is None:
                references = self._used
            else:
                self._begin(self._pending, source, kinematics, references)
        if self._follow is None:
            plan = Plan(self._stack.linearise(kinematics, references), None, 1.0)
        else:
            plan = self._blend(self._follow, kinematics, references)
        self._used = references
        return plan

    def finish(self, plan: Plan, chi: Vector) -> TransitionState:
        """Return what to tell of this tick, after ``chi`` (n,) was solved; adopt at the end."""
        gap = 0.0 if plan.source is None else float(np.max(np.abs(chi - plan.source)))
        told = self._told(plan.alpha, gap)
        self._aborted = ""
        if self._follow is not None and plan.alpha >= 1.0 and self._config.at_end == "adopt":
            self._adopt(self._follow)
        return told

    # ---- inside

    def _ask(self, stack: str, duration: float, method: str, at_tick: int, reason: str) -> Answer:
        answer = self._book.ask(stack, duration, method, at_tick, self._tick, reason)
        if answer.request is not None:
            self._announce(answer.request, active=True)
        return answer

    def _announce(self, request: SwitchRequest, *, active: bool) -> None:
        self._outbox.append(Announcement(request.id, request.stack, request.at_tick, active))

    def _fresh(self, id_: int, tick: int) -> Vector | None:
        """Return the source's chi for a transition if it is new enough, else None."""
        heard = self._heard
        if heard is None or heard.transition_id != id_ or not heard.solved:
            return None
        return heard.chi if 0 <= tick - heard.tick <= self._stale else None

    def _is_back(self, follow: _Follow) -> bool:
        """Return whether the source, once lost, has been heard again."""
        heard = self._heard
        return (
            heard is not None
            and heard.transition_id == follow.request.id
            and heard.solved
            and heard.tick > follow.start
        )

    def _first_source(self, request: SwitchRequest) -> Source | None:
        """Return whom to follow into a new stack, or None while the wait goes on."""
        if self._fresh(request.id, self._tick) is not None:
            return Source.ROBOT_B
        if self._tick - request.at_tick >= self._patience:
            return Source(self._config.on_loss)
        return None

    def _begin(
        self,
        request: SwitchRequest,
        source: Source,
        kinematics: Kinematics,
        references: References,
    ) -> None:
        """Start to follow: the pending request becomes the blend under way."""
        self._reason = request.reason
        if self._follow is not None and not request.reason:
            self._reason = f"pre-empted transition {self._follow.request.id}"
        if source is not Source.ROBOT_B:
            self._reason = _join(
                self._reason, f"robot B sent no chi by tick {self._tick}: {_instead(source)}"
            )
        self._id, self._from, self._pending = request.id, self._stack.name, None
        self._relatch(request, source, kinematics, references)

    def _relatch(
        self,
        request: SwitchRequest,
        source: Source,
        kinematics: Kinematics,
        references: References,
    ) -> None:
        """Latch delta and epsilon anew at this tick; alpha starts again from 0."""
        new = self._stacks[request.stack]
        level = new.levels[0].linearise(kinematics, references)
        assert self._used is not None  # set by step before the first latch
        before = self.target.levels[0].linearise(kinematics, self._used)
        steady = self._follow is None or self._follow.bridge.epsilon is None
        chi = self._source_chi(request, source, kinematics, references)
        bridge = latch(kinematics.state.command, chi, level, steady and same_level(level, before))
        self._follow = _Follow(request, source, self._tick, bridge)

    def _source_chi(
        self,
        request: SwitchRequest,
        source: Source,
        kinematics: Kinematics,
        references: References,
    ) -> Vector:
        """Return the chi to go to at this tick, shape (n,)."""
        if source is Source.ROBOT_B:
            fresh = self._fresh(request.id, self._tick)
            assert fresh is not None  # the callers have looked
            return fresh
        if source is Source.LOCAL:
            return self._local.chi(request.stack, kinematics, references)
        return np.zeros_like(kinematics.state.command)

    def _blend(self, follow: _Follow, kinematics: Kinematics, references: References) -> Plan:
        """Return the two levels of the bridge; re-latch where the source or level 1 changed."""
        source = self._present_source(follow)
        moved = references is not self._used and follow.start != self._tick
        if source is not follow.source or (
            moved and not self._level_goes_on(follow, kinematics, references)
        ):
            self._relatch(follow.request, source, kinematics, references)
            assert self._follow is not None
            follow = self._follow
        chi = self._source_chi(follow.request, source, kinematics, references)
        level = self.target.levels[0].linearise(kinematics, references)
        part = alpha(
            self._config.profile, (self._tick - follow.start) * self._dt, follow.request.duration
        )
        return Plan(bridged(follow.bridge, level, chi, part), chi, part)

    def _level_goes_on(
        self, follow: _Follow, kinematics: Kinematics, references: References
    ) -> bool:
        """Return whether level 1 asks for the same under new references as under the old."""
        assert self._used is not None
        level = self._stacks[follow.request.stack].levels[0]
        return same_level(
            level.linearise(kinematics, references), level.linearise(kinematics, self._used)
        )

    def _present_source(self, follow: _Follow) -> Source:
        """Return whom to follow at this tick: B where it is fresh, else as configured."""
        if self._fresh(follow.request.id, self._tick) is not None:
            if follow.source is not Source.ROBOT_B:
                self._reason = f"robot B is back at tick {self._tick}"
            return Source.ROBOT_B
        if follow.source is not Source.ROBOT_B:
            return follow.source
        lost = Source(self._config.on_loss)
        heard = "nothing" if self._heard is None else f"tick {self._heard.tick}"
        self._reason = f"robot B lost at tick {self._tick}, last heard {heard}: {_instead(lost)}"
        return lost

    def _adopt(self, follow: _Follow) -> None:
        """Take the new stack over; the source may rest."""
        self._stack = self._stacks[follow.request.stack]
        if follow.source is Source.MINIMUM_VELOCITY:
            self._stack = self._local.at_rest(follow.request.stack)
            self._aborted = f"{self._reason}; at rest"
        self._announce(follow.request, active=False)
        self._follow = None

    def _told(self, part: float, gap: float) -> TransitionState:
        """Return the state of this tick in the words of the message."""
        follow, pending = self._follow, self._pending
        state = TransitionState(
            self._id,
            self._from,
            self.target.name,
            Source.NONE if follow is None else follow.source,
            "" if follow is None else follow.request.method,
            Phase.IDLE,
            part,
            0.0 if follow is None else follow.request.duration,
            gap,
            self._reason,
        )
        if self._aborted:
            return replace(state, phase=Phase.ABORTED, reason=self._aborted)
        if follow is not None:
            at_end = part >= 1.0 and self._config.at_end == "adopt"
            return replace(state, phase=Phase.ADOPTING if at_end else Phase.BLENDING)
        coming = pending or (self._book.scheduled[0] if self._book.scheduled else None)
        if coming is None:
            return state
        phase = Phase.REQUESTED if pending is None else Phase.PREPARING
        return replace(state, id=coming.id, to_stack=coming.stack, phase=phase, alpha=0.0)


def _instead(source: Source) -> str:
    """Return what A follows in place of robot B, in words."""
    if source is Source.LOCAL:
        return "robot A solves the new stack itself"
    return "robot A goes to minimum velocity"


def _join(first: str, second: str) -> str:
    """Return two reasons as one line."""
    return f"{first}; {second}" if first else second
