"""The recorded states as the library takes them, and when each message counted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Generic, TypeVar

import numpy as np

from lexstack.references import Target as ScheduledTarget
from lexstack.robots import Team
from lexstack.types import RobotState
from lexstack_bag.run.partial_chi import concatenated, rows_of
from lexstack_bag.run.references import scheduled
from lexstack_bag.run.run import ChiStream, Integers, Run

T = TypeVar("T")

EVER = 2**63 - 1  # ns


class States:
    """The plant's states by tick."""

    def __init__(self, run: Run) -> None:
        """Look at a run."""
        self._plant = run.plant
        self._rows = {int(tick): row for row, tick in enumerate(run.plant.tick)}

    def __contains__(self, tick: int) -> bool:
        """Return whether the bag has the state of a tick."""
        return tick in self._rows

    def between(self, first: int, last: int) -> list[int]:
        """Return the ticks from the first to the last whose state the bag has."""
        return [int(tick) for tick in self._plant.tick if first <= tick <= last]

    def __getitem__(self, tick: int) -> RobotState:
        """Return the state of a tick, bit by bit as the nodes had it."""
        row, plant = self._rows[tick], self._plant
        return RobotState(
            tick,
            float(plant.stamp[row]),
            plant.q[row],
            plant.v[row],
            plant.q_star[row],
            plant.command[row],
        )


def begun_at(chi: ChiStream) -> Integers:
    """Return when a node began to solve each row [ns since 1970]: it knew what came before.

    A node sends its chi right after the solve, whose time it tells.
    """
    if len(chi.sent) != len(chi.tick):
        return np.full(len(chi.tick), EVER)
    return np.asarray(chi.sent - np.round(1e9 * np.nan_to_num(chi.solve_time)).astype(np.int64))


def all_of(run: Run, node: str) -> ChiStream:
    """Return every chi of a node in the order of sending, several of a tick where it sent them."""
    one, other = run.chi[node], run.replaced.get(node)
    if other is None or not len(other.tick):
        return one
    rows = concatenated([one, other])
    return rows_of(rows, np.argsort(rows.sent, kind="stable"))


class Arrivals(Generic[T]):
    """Things that came one after another, handed out as time goes on."""

    def __init__(self, items: Sequence[tuple[int, T]]) -> None:
        """Take the things with their times, in any order."""
        self._items = sorted(items, key=lambda item: item[0])
        self._next = 0

    def until(self, time: int) -> Iterator[T]:
        """Yield those before a time that were not handed out yet."""
        while self._next < len(self._items) and self._items[self._next][0] < time:
            self._next += 1
            yield self._items[self._next - 1][1]


def targets_of(run: Run, team: Team) -> Arrivals[ScheduledTarget]:
    """Return the references that users sent, by the time of their arrival [ns since 1970]."""
    known = [target for target in run.targets if target.robot in team.names]
    return Arrivals([(target.arrived, scheduled(target, team)) for target in known])
