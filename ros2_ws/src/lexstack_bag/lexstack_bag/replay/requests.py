"""What users asked of robot A, as the bag shows it: which switch, when, and what was cancelled.

A tells its source of every request that it accepted, and its status tells duration and method.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from lexstack_bag.replay.changes import Changes
from lexstack_bag.run import Run, StackRequested, TransitionPhase
from lexstack_core.config.resolved import ResolvedScenario


@dataclass(frozen=True, slots=True)
class Ask:
    """A request to switch that robot A accepted.

    Attributes:
        after: the tick that A had served last; -1: none.
        id: that A gave it.
        stack: where to go.
        at_tick: when to begin.
        duration: of the blend [s]; 0: as configured.
        method: empty: as configured.
    """

    after: int
    id: int
    stack: str
    at_tick: int
    duration: float
    method: str


@dataclass(frozen=True, slots=True)
class Cancel:
    """A cancellation, which drops what is scheduled."""

    after: int


def requests_of(run: Run, changes: Changes, resolved: ResolvedScenario) -> list[Ask | Cancel]:
    """Return the requests in their order.

    A duration or method that was the configured one stays "as configured": so a change of the
    configuration applies to it. ``--method`` applies to all.

    Args:
        run: as recorded.
        changes: to be made.
        resolved: the scenario with the changes made.
    """
    begun = _beginnings(run)
    old, new = changes.stacks(resolved)
    requests = list(_reconstructed(run.requested, {id_: tick for id_, (tick, *_) in begun.items()}))
    configured = run.resolved.scenario.transition
    for place, request in enumerate(requests):
        if isinstance(request, Cancel):
            continue
        _, duration, method = begun.get(request.id, (0, configured.duration, configured.method))
        stack = new if new and old in ("", request.stack) else request.stack
        as_configured = changes.method or method == configured.method
        requests[place] = replace(
            request,
            stack=stack,
            duration=0.0 if duration == configured.duration else duration,
            method="" if as_configured else method,
        )
    return requests


def _beginnings(run: Run) -> dict[int, tuple[int, float, str]]:
    """Return first tick, duration [s] and method of the blends that began, by id."""
    status = run.transition
    blending = np.isin(status.phase, (TransitionPhase.BLENDING, TransitionPhase.ADOPTING))
    found: dict[int, tuple[int, float, str]] = {}
    for row in np.flatnonzero(blending):
        entry = int(status.tick[row]), float(status.duration[row]), str(status.method[row])
        found.setdefault(int(status.id[row]), entry)
    return found


def _reconstructed(
    messages: Iterable[StackRequested], begun: dict[int, int]
) -> Iterator[Ask | Cancel]:
    """Yield what was asked, from what A told its source.

    The first active message of an id is the request. A request that has not begun is taken back
    by a cancellation alone, which takes back all of them; one that goes back smoothly is a request
    like any other.
    """
    known: set[int] = set()
    coming: set[int] = set()
    for message in messages:
        coming = {id_ for id_ in coming if not 0 <= begun.get(id_, -1) <= message.after}
        if message.active and message.id not in known:
            known.add(message.id)
            coming.add(message.id)
            yield Ask(message.after, message.id, message.stack, message.start_tick, 0.0, "")
        elif not message.active and message.id in coming and not message.start_tick:
            coming.clear()
            yield Cancel(message.after)
