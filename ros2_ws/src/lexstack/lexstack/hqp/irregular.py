"""Which groups of robots may need rows, from what is known of states nearby."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from lexstack.compiled import kernel
from lexstack.hqp.chain_levels import ChainLevels
from lexstack.hqp.groups import Group, Slices, groups_of
from lexstack.hqp.lift import GroupLevel
from lexstack.hqp.margin import Margin
from lexstack.hqp.problem import HqpProblem
from lexstack.hqp.regular import regular_levels
from lexstack.robots import Kinematics
from lexstack.types import Curve, Vector

_LASTING = 4  # looks that a margin must have spared, or the next one is made later
_PAUSES = (1, 15)  # looks between two margins, least and most
_MOST = 32  # sets of tasks that are remembered

Share = tuple[Group, list[GroupLevel], int]
"""A group, its share of each level, and how many of these are regular."""

Curves = tuple[tuple[Curve, ...], ...]
"""Of the tasks of all levels down to the last one that has any."""


@dataclass(slots=True)
class _Known:
    """What is known of problems with the same tasks."""

    groups: tuple[Group, ...]
    margins: list[Margin | None]
    spared: list[int]  # looks, by each margin
    pause: list[int]
    wait: list[int]  # so many looks more before another margin is made
    chains: list[ChainLevels | None]  # where the compiled test can be asked

    @classmethod
    def of(cls, groups: tuple[Group, ...], problem: HqpProblem) -> _Known:
        """Return what is known of groups at first: nothing."""
        zeros, chains = [0] * len(groups), [ChainLevels.of(group, problem) for group in groups]
        return cls(groups, [None] * len(groups), list(zeros), list(zeros), list(zeros), chains)

    def regular(self, i: int, problem: HqpProblem, kinematics: Kinematics) -> bool:
        """Return whether a group is regular by the compiled test, where no margin is to be made."""
        chain, fast = self.chains[i], kernel("lexstack.hqp.kernel.regular")
        if chain is None or fast is None or self.wait[i] < 1:
            return False
        if not chain.regular(problem, kinematics, fast):
            return False
        self.wait[i] -= 1
        return True

    def look(
        self, i: int, levels: list[GroupLevel], problem: HqpProblem, kinematics: Kinematics
    ) -> None:
        """Make a margin of a group that was found regular, unless one was made lately in vain."""
        self.wait[i] -= 1
        if self.wait[i] >= 0:
            return
        least, most = _PAUSES
        self.pause[i] = least if self.spared[i] >= _LASTING else min(2 * self.pause[i] + 1, most)
        self.wait[i], self.spared[i] = self.pause[i], 0
        self.margins[i] = Margin.of(self.groups[i], levels, problem, kinematics)


class Margins:
    """Finds the levels that may need rows; it remembers margins, on which no result depends."""

    def __init__(self, slices: Slices) -> None:
        """Know which joints are whose."""
        self._slices = slices
        self._known: dict[Curves, _Known] = {}

    def irregular(
        self, problem: HqpProblem, sides: Vector | None, kinematics: Kinematics
    ) -> list[Share]:
        """Return the groups for which ``lift`` may add rows.

        Args:
            problem: over all joints of a team.
            sides: not zero where a joint stands at a position limit; None: no joint does.
            kinematics: of this tick.
        """
        known = self._of(problem)
        groups = groups_of(problem, self._slices) if known is None else known.groups
        found = []
        for i, group in enumerate(groups):
            held = None if sides is None else sides[group.columns]
            if held is not None and not np.count_nonzero(held):
                held = None
            margin = known.margins[i] if known is not None and held is None else None
            if known is not None and margin is not None and margin.covers(problem):
                known.spared[i] += 1
                continue
            if known is not None and held is None and known.regular(i, problem, kinematics):
                continue
            levels = group.levels(problem)
            regular = regular_levels(levels, held, kinematics, group.places)
            if regular < len(levels):
                found.append((group, levels, regular))
            elif known is not None and held is None:
                known.look(i, levels, problem, kinematics)
        return found

    def _of(self, problem: HqpProblem) -> _Known | None:
        """Return what is known of a problem's tasks; None where one of them has no curve."""
        curves = [tuple([task.curve for task in level]) for level in problem.levels]
        while curves and curves[-1].count(None) == len(curves[-1]):
            curves.pop()
        for level in curves:
            if None in level:
                return None
        key = cast("Curves", tuple(curves))
        known = self._known.get(key)  # curves are told apart by identity: it is quick
        if known is None:
            groups = groups_of(problem, self._slices)
            known = _Known.of(groups, problem)
            if len(self._known) >= _MOST:
                self._known.clear()
            self._known[key] = known
        return known
