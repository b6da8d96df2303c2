"""What users asked of the controller, by the bag: which switch, when, and what was cancelled.

The controller tells its source of every request that it accepted; its status tells duration and
method, and what was cancelled.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from lexstack_bag.figures.series import COMMANDER
from lexstack_bag.replay.changes import Changes
from lexstack_bag.run.run import Run, StackRequested, TransitionPhase
from lexstack_config.resolved import ResolvedScenario

_CANCELLED, _GOING_BACK = "cancelled", "going back"
"""What the controller says in the reason of its status, see Transition.cancel."""


@dataclass(frozen=True, slots=True)
class Ask:
    """A request to switch that the controller accepted.

    Attributes:
        after: the tick that the controller had served last; -1: none.
        id: that the controller gave it.
        stack: where to go.
        at_tick: when to begin.
        duration: of the blend [s]; 0: as configured.
        method: empty: as configured.
        robots: names of those that shall go; empty: all that the stack moves.
        text: YAML of the stack, where a user sent it.
    """

    after: int
    id: int
    stack: str
    at_tick: int
    duration: float
    method: str
    robots: tuple[str, ...] = ()
    text: str = ""


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
    requests = list(_reconstructed(run, begun))
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


def _reconstructed(run: Run, begun: Collection[int]) -> Iterator[Ask | Cancel]:
    """Yield what was asked, gap by gap between two of its ticks; ``begun``: ids that did.

    The first active message of an id is the request. A cancellation drops what has not begun, and
    asks by itself to go back: those requests are not the user's.
    """
    cancelled, own = _cancelled_after(run), _going_back(run)
    gaps: dict[int, list[StackRequested]] = {after: [] for after in cancelled}
    for message in run.requested:
        gaps.setdefault(message.after, []).append(message)
    known: set[int] = set()
    for after, messages in sorted(gaps.items()):
        asks = []
        for message in messages:
            if message.active and message.id not in known | own:
                robots = _some(run, message)
                entry = after, message.id, message.stack, message.start_tick
                asks.append(Ask(*entry, 0.0, "", robots, message.text))
            known.add(message.id)
        if after not in cancelled:
            yield from asks
            continue
        ended = {message.id for message in messages if not message.active} - set(begun)
        yield from (ask for ask in asks if ask.id in ended)
        yield Cancel(after)
        yield from (ask for ask in asks if ask.id not in ended)


def _some(run: Run, message: StackRequested) -> tuple[str, ...]:
    """Return the robots that a request is for, empty if those are all that its stack moves."""
    stack = run.resolved.stacks.get(message.stack)
    moved = (stack.robots if stack is not None else ()) or run.robots
    return () if set(message.robots) == set(moved) else message.robots


def _cancelled_after(run: Run) -> set[int]:
    """Return the ticks after which the controller was told to cancel; -1: before the first."""
    status = run.transition
    told = [
        int(tick)
        for tick, phase, reason in zip(status.tick, status.phase, status.reason, strict=True)
        if phase == TransitionPhase.ABORTED and _CANCELLED in str(reason)
    ]
    served = run.chi[COMMANDER].tick
    before = np.searchsorted(served, told) - 1
    return {int(served[place]) if place >= 0 else -1 for place in before}


def _going_back(run: Run) -> set[int]:
    """Return the ids of the requests that a cancellation made by itself."""
    status = run.transition
    return {
        int(id_)
        for id_, reason in zip(status.id, status.reason, strict=True)
        if _GOING_BACK in str(reason)
    }
