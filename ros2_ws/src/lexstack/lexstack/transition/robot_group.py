"""Some of the robots, and their part of chi."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack.types import LinearTask, Matrix, Vector

Columns = slice | NDArray[np.intp]
"""Joints in chi; a slice where they stand side by side."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotGroup:
    """Some robots of a team, in its order.

    Attributes:
        robots: their places.
        names: of the robots.
        columns: their joints in chi; a slice where they stand side by side.
        pieces: per piece of the columns, which no follow task couples with the others: its name,
            its columns, and these rows of the identity, shape (m, n).
        team: that they belong to.
    """

    robots: tuple[int, ...]
    names: tuple[str, ...]
    columns: Columns
    pieces: tuple[tuple[str, slice, Matrix], ...]
    team: Team

    @classmethod
    def of(cls, team: Team, robots: Iterable[int]) -> RobotGroup:
        """Return the group of these robots of a team."""
        places = tuple(sorted(robots))
        names = tuple(team.names[robot] for robot in places)
        slices = [team.slices[robot] for robot in places]
        joints = team.columns(places)
        columns: Columns = joints
        if joints.size == joints[-1] + 1 - joints[0]:
            columns = slice(int(joints[0]), int(joints[-1]) + 1)
        if len(places) == len(team.robots):
            whole = ("follow_chi", slice(0, team.n), _unit_rows(team.n, slice(0, team.n)))
            return cls(places, names, columns, (whole,), team)
        pieces = tuple(
            (f"{name}/follow_chi", columns, _unit_rows(team.n, columns))
            for name, columns in zip(names, slices, strict=True)
        )
        return cls(places, names, columns, pieces, team)

    def shares(self, other: RobotGroup) -> bool:
        """Return whether two groups have a robot in common."""
        return not set(self.robots).isdisjoint(other.robots)

    def follow(self, target: Vector) -> tuple[LinearTask, ...]:
        """Return the level chi -> target, shape (n,), on these robots' joints, T(33)."""
        return tuple(
            [
                LinearTask.equality(name, rows, target[columns])
                for name, columns, rows in self.pieces
            ]
        )


def _unit_rows(n: int, columns: slice) -> Matrix:
    """Return rows of the identity; read-only, as solvers may remember them."""
    rows: Matrix = np.eye(columns.stop - columns.start, n, columns.start)
    rows.setflags(write=False)
    return rows


class RobotGroups:
    """The groups of one team, each made when it is first asked for."""

    def __init__(self, team: Team) -> None:
        """Know the team."""
        self._team = team
        self._made: dict[tuple[int, ...], RobotGroup] = {}

    def __call__(self, robots: Iterable[int]) -> RobotGroup:
        """Return the group of some robots, by their places."""
        key = tuple(sorted(robots))
        if key not in self._made:
            self._made[key] = RobotGroup.of(self._team, key)
        return self._made[key]
