"""Which announcements were sent to the source, and which have to be sent next."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lexstack.transition.messages import Announcement
from lexstack.transition.requests import SwitchRequest

Wanted = tuple[SwitchRequest, int | None]
"""A request whose stack the source shall solve, and the first tick that it is not needed for."""


def wanted_of(requests: Iterable[SwitchRequest], followed: Iterable[Wanted]) -> dict[int, Wanted]:
    """Return all that the source shall solve, for requests to come and for blends, by their id."""
    wanted: dict[int, Wanted] = {request.id: (request, None) for request in requests}
    for request, end in followed:
        # A request whose robots are on several channels ends with the last of them.
        other = wanted[request.id][1] if request.id in wanted else end
        both = None if end is None or other is None else max(end, other)
        wanted[request.id] = request, both
    return wanted


class Announcer:
    """Returns every change once."""

    def __init__(self) -> None:
        """Start with nothing announced."""
        self._announced: dict[int, Wanted] = {}

    def changes(self, wanted: Mapping[int, Wanted]) -> list[Announcement]:
        """Return what is new, given all that is wanted now by transition id."""
        if not wanted and not self._announced:
            return []
        news = []
        for id_, (request, end) in wanted.items():
            announced = self._announced.get(id_)
            if announced is None or (announced[1] is not None and end is None):
                news.append(_word(request, request.at_tick, active=True))
            if end is not None and (announced is None or announced[1] != end):
                news.append(_word(request, end, active=False))
        for id_, (request, end) in self._announced.items():
            if id_ not in wanted and end is None:
                news.append(_word(request, 0, active=False))
        self._announced = dict(wanted)
        return news


def _word(request: SwitchRequest, tick: int, *, active: bool) -> Announcement:
    """Return the announcement of a request or of its end."""
    return Announcement(request.id, request.stack, tick, active, request.robots)
