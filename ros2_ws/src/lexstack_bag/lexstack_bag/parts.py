"""Chi of some robots alone, from one of several solvers, among the joints of all robots."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack_bag.run import ChiStream, Run, read_only
from lexstack_core.model import Team

_VECTORS = ("chi", "lower", "upper")


def robots_of(names: str, team: Team) -> tuple[int, ...]:
    """Return the places of the robots that a row of chi is about; all where it names none."""
    named = set(names.split())
    found = tuple(place for place, name in enumerate(team.names) if name in named)
    return found or tuple(range(len(team.names)))


def among_all(message: Any, team: Team) -> Any:
    """Return a decoded chi with a place for every joint: nan for those that it is not about."""
    robots = robots_of(" ".join(message.robots), team)
    if len(robots) == len(team.names):
        return message
    columns = team.columns(robots)
    whole = {}
    for name in _VECTORS:
        values = getattr(message, name)
        if len(values) == columns.size:
            whole[name] = np.full(team.n, np.nan)
            whole[name][columns] = values
    return dataclasses.replace(message, **whole)


def joined(run: Run, node: str) -> ChiStream:
    """Return the chi of a node tick by tick, joined from all messages of each tick.

    A row is the last message of its tick; joints that this is not about are those of the last
    message before it that is.
    """
    last, before = run.chi[node], run.replaced.get(node)
    if before is None or not len(before.tick) or not len(last.tick):
        return last
    rows = np.minimum(np.searchsorted(last.tick, before.tick), len(last.tick) - 1)
    same = last.tick[rows] == before.tick
    whole: dict[str, NDArray[Any]] = {}
    for name in _VECTORS:
        values, others = getattr(last, name), getattr(before, name)
        row, column = np.nonzero(np.isnan(values[rows]) & ~np.isnan(others) & same[:, None])
        filled = values.copy()
        filled[rows[row], column] = others[row, column]  # of several the last one stays
        whole[name] = read_only(filled)
    return dataclasses.replace(last, **whole)
