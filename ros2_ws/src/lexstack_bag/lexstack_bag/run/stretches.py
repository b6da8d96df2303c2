"""Where the parts of a bag begin: at every reset, and where another simulation sends the states.

Anybody may send on ``/plant/state``. States of a stranger, among those of a sender that goes on
after them, are no part: nodes refuse them too.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True, slots=True)
class Stretch:
    """States of one sender between two resets, one after another.

    Attributes:
        sender: who sent them; '' in bags of before senders.
        resets: how often the plant was reset before.
        sent: when the first of them was sent [ns since 1970].
        first: its tick.
        last: the tick of the last one.
    """

    sender: str
    resets: int
    sent: int
    first: int
    last: int

    def holds(self, state: Any) -> bool:
        """Return whether a decoded state is of this sender and between these resets."""
        return (self.sender, self.resets) == _origin(state)


class Stretches:
    """Takes the states of a bag in their order.

    Attributes:
        found: so far.
    """

    def __init__(self) -> None:
        """Know no state yet."""
        self.found: list[Stretch] = []

    def see(self, state: Any, sent: int) -> None:
        """Take a decoded state that was sent at a time [ns since 1970]."""
        tick = int(state.tick)
        now = self.found[-1] if self.found else None
        if now is None or not now.holds(state) or tick < now.last:
            self.found.append(Stretch(*_origin(state), sent, tick, tick))
        elif tick > now.last:
            self.found[-1] = replace(now, last=tick)


def without_strangers(stretches: Iterable[Stretch]) -> list[Stretch]:
    """Return stretches without those after which an earlier one goes on; this one is one then."""
    kept: list[Stretch] = []
    for stretch in stretches:
        origin = (stretch.sender, stretch.resets)
        same = [i for i, each in enumerate(kept) if (each.sender, each.resets) == origin]
        if same and kept[same[-1]].last <= stretch.first:
            del kept[same[-1] + 1 :]
            kept[-1] = replace(kept[-1], last=stretch.last)
        else:
            kept.append(stretch)
    return kept


def _origin(state: Any) -> tuple[str, int]:
    """Return sender and resets of a state; older bags have neither."""
    return str(getattr(state, "sender", "")), int(getattr(state, "resets", 0))
