"""Requests to switch the stack: checked, numbered, and kept until their tick comes."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from lexstack.options import shown, unknown
from lexstack.transition.options import TransitionConfig

MAX_DURATION = 60.0
"""The longest transition [s]."""

MAX_SCHEDULED = 64
"""So many requests may wait for their ticks."""


@dataclass(frozen=True, slots=True)
class SwitchRequest:
    """A request that was accepted.

    Attributes:
        id: transition id, counted from 1.
        stack: the stack to go to.
        robots: places in the team of the robots that go there.
        duration: of the blend [s].
        method: of the transition.
        profile: of alpha.
        at_tick: the tick at which the blend starts, if the source's solution is there.
        reason: why, where it is not a user's wish: empty, or one line.
    """

    id: int
    stack: str
    robots: tuple[int, ...]
    duration: float
    method: str
    profile: str
    at_tick: int
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a request: accepted with an id, or refused with the reason."""

    accepted: bool
    message: str
    request: SwitchRequest | None = None


class RequestBook:
    """Accepted requests in the order of their ticks.

    A later request for the same tick, or one that is due later while an earlier one still waits,
    replaces the earlier one where it moves all of its robots.

    Attributes:
        pending: requests that are due, but wait for a first chi or for an older request.
    """

    def __init__(
        self,
        stacks: Mapping[str, tuple[int, ...]],
        methods: Collection[str],
        defaults: TransitionConfig,
        unfit: Mapping[str, str] | None = None,
        *,
        horizon: int = 6000,
    ) -> None:
        """Know what may be asked for.

        Args:
            stacks: the robots' places that each moves, by name.
            methods: names of the transition methods.
            defaults: what empty fields mean.
            unfit: why other stacks of the configuration cannot be asked for, by name.
            horizon: so many ticks ahead a request may be.
        """
        self._stacks = stacks
        self._unfit = unfit or {}
        self._methods = methods
        self._horizon = horizon
        self._duration = defaults.duration
        self._method: str = defaults.method
        self._profile: str = defaults.profile
        self.pending: tuple[SwitchRequest, ...] = ()
        self._scheduled: list[SwitchRequest] = []
        self._count = 0

    def set_defaults(self, duration: float, method: str) -> None:
        """Change what an empty duration [s] and method stand for from now on."""
        self._duration, self._method = duration, method

    def ask(
        self,
        stack: str,
        duration: float,
        method: str,
        at_tick: int,
        now: int,
        *,
        reason: str = "",
        robots: tuple[int, ...] | None = None,
    ) -> Answer:
        """Return the answer to a request made while ``now`` is the last tick that was served.

        Args:
            stack: name of the stack to go to.
            duration: of the blend [s]; 0: as configured.
            method: empty: as configured.
            at_tick: 0: the next tick.
            now: the last tick.
            reason: why, if not a user's wish.
            robots: places of those that shall go there; None: all that the stack moves.
        """
        rejection = self._rejection_reason(stack, duration, method)
        if rejection:
            return Answer(False, rejection)
        moved = self._stacks[stack] if robots is None else robots
        rejection = self._untimely(moved, at_tick, now)
        if rejection:
            return Answer(False, rejection)
        self._count += 1
        request = SwitchRequest(
            self._count,
            stack,
            moved,
            duration or self._duration,
            method or self._method,
            self._profile,
            at_tick or now + 1,
            reason,
        )
        self._scheduled = [
            entry
            for entry in self._scheduled
            if entry.at_tick != request.at_tick or not _covers(request, entry)
        ]
        self._scheduled.append(request)
        self._scheduled.sort(key=lambda entry: entry.at_tick)  # stable: keeps their order
        text = f"transition {request.id} to {stack!r} starts at tick {request.at_tick}"
        return Answer(True, text, request)

    def robots(self, stack: str) -> tuple[int, ...]:
        """Return the places of the robots that a known stack moves."""
        return self._stacks[stack]

    def peek(self, tick: int) -> tuple[SwitchRequest, ...]:
        """Return the requests whose tick has come, older ones first, that none of them replaces."""
        if not self._scheduled:
            return self.pending
        due = in_effect([request for request in self._scheduled if request.at_tick <= tick])
        return in_effect((*self.pending, *due)) if due else self.pending

    def due(self, tick: int, waiting: tuple[SwitchRequest, ...] = ()) -> tuple[SwitchRequest, ...]:
        """Return what ``peek`` does, and forget it and what was replaced, all but ``waiting``."""
        found = self.peek(tick)
        self.pending = waiting
        self._scheduled = [entry for entry in self._scheduled if entry.at_tick > tick]
        return found

    @property
    def scheduled(self) -> tuple[SwitchRequest, ...]:
        """Requests whose tick has not come yet."""
        return tuple(self._scheduled)

    @property
    def not_begun(self) -> tuple[SwitchRequest, ...]:
        """All that wait, those that are due first."""
        return (*self.pending, *self._scheduled)

    def clear(self) -> None:
        """Forget all that has not begun."""
        self.pending = ()
        self._scheduled = []

    def _rejection_reason(self, stack: str, duration: float, method: str) -> str:
        """Return why a request cannot be accepted, or an empty text."""
        if stack not in self._stacks:
            return self._absent(stack)
        if not math.isfinite(duration) or not 0.0 <= duration <= MAX_DURATION:
            return (
                f"duration: must be in [0, {MAX_DURATION:g}] s (0: as configured), got {duration}"
            )
        if method and method not in self._methods:
            return unknown("method", method, self._methods)
        return ""

    def _untimely(self, robots: tuple[int, ...], at_tick: int, now: int) -> str:
        """Return why robots cannot switch at a tick, or an empty text.

        Each robot has a queue of its own: requests for others never keep it from switching.
        """
        if at_tick and at_tick <= now:
            return f"at_tick: {at_tick} is over; the present tick is {now}"
        mine = [entry for entry in self._scheduled if set(entry.robots) & set(robots)]
        full = at_tick and len(mine) >= MAX_SCHEDULED  # what begins at once waits for nothing
        if full and all(entry.at_tick != at_tick for entry in mine):
            return f"{MAX_SCHEDULED} requests are scheduled already; wait for one to be served"
        return too_far(at_tick, now, self._horizon)

    def _absent(self, stack: str) -> str:
        """Return why a stack cannot be asked for: it does not fit, or nobody knows it."""
        if stack in self._unfit:
            return f"stack {stack!r} does not fit: {self._unfit[stack]}"
        return f"unknown stack {shown(stack)}; known: {', '.join(sorted(self._stacks))}"


def too_far(at_tick: int, now: int, horizon: int) -> str:
    """Return why a tick is too far ahead of the present one, or ''; all in ticks."""
    if at_tick - now <= horizon:
        return ""
    return (
        f"at_tick: {at_tick} is {at_tick - now} ticks ahead of the present tick {now}, "
        f"more than {horizon}"
    )


def in_effect(requests: Sequence[SwitchRequest]) -> tuple[SwitchRequest, ...]:
    """Return the requests, in their order, that no later one replaces."""
    return tuple(
        request
        for i, request in enumerate(requests)
        if not any(_covers(later, request) for later in requests[i + 1 :])
    )


def _covers(later: SwitchRequest, earlier: SwitchRequest) -> bool:
    """Return whether a request moves all robots of another one."""
    return set(earlier.robots) <= set(later.robots)
