"""Which of the requests whose tick has come begin, wait or are dropped: decided once a tick."""

from __future__ import annotations

from dataclasses import dataclass

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
