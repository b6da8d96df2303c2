"""Which of the requests whose tick has come begin, wait or are dropped: decided once a tick."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from lexstack.tasks.stack import Stack
from lexstack.transition.channels.channel import Channel
from lexstack.transition.channels.lineup import GroupOf, as_requested, coupling
from lexstack.transition.requests import SwitchRequest
from lexstack.transition.sources.inbox import Choice


@dataclass(frozen=True, slots=True)
class Due:
    """The requests that are due at one tick; all that is done in the tick uses this record.

    Attributes:
        tick: that is served.
        starting: those that begin, in their order, each with whom to follow.
        waiting: those that wait, for the solver's first chi or an older request of the same robots.
        dropped: those that cannot be served any more, each with the reason.
    """

    tick: int
    starting: tuple[tuple[SwitchRequest, Choice], ...] = ()
    waiting: tuple[SwitchRequest, ...] = ()
    dropped: tuple[tuple[SwitchRequest, str], ...] = ()

    @property
    def requested(self) -> bool:
        """Whether any request is due."""
        return bool(self.starting or self.waiting or self.dropped)

    @classmethod
    def decided(
        cls,
        tick: int,
        requested: Iterable[SwitchRequest],
        first: Callable[[SwitchRequest], Choice | None],
        channels: Sequence[Channel],
        stacks: Mapping[str, Stack],
        group_of: GroupOf,
    ) -> Due:
        """Return what becomes of each request whose tick has come.

        A request waits for the solver's first chi, and for every older one that shares a robot. One
        whose robots are coupled with others by now is dropped.

        Args:
            tick: that is to be served.
            requested: the requests, the older ones first.
            first: returns whom a request's robots would follow; None: the wait goes on.
            channels: of all robots.
            stacks: all that may be asked for, by name.
            group_of: makes the group of some robots.
        """
        starting, waiting, dropped = [], [], []
        held = set[int]()
        for request in requested:
            choice = first(request)
            if choice is None or held.intersection(request.robots):
                waiting.append(request)
                held.update(request.robots)
                continue
            coupled = coupling(channels, group_of(request.robots))
            if coupled:
                dropped.append((request, coupled))
                continue
            starting.append((request, choice))
            channels = as_requested(channels, [request], stacks, group_of)
        return cls(tick, tuple(starting), tuple(waiting), tuple(dropped))
