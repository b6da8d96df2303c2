"""The phases of a run: which stack the controller was on or on its way to, from when to when."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lexstack.tasks import TaskConfig
from lexstack.types import Vector
from lexstack_bag.figures.series import COMMANDER
from lexstack_bag.run.run import Run, TransitionPhase

EE_TASKS = frozenset({"ee_pose", "ee_position"})
BASE_TASKS = frozenset({"base"})
POSTURE_TASKS = frozenset({"posture"})
RELATIVE_TASKS = frozenset({"relative_pose"})
"""Tasks with figures of their own; ``task_errors`` has those of all others."""

_OF_OBJECTS = frozenset({"other", "gain", "max_linear", "max_angular"})

_CANCELLED = re.compile(r"transitions? (\d+(?:, \d+)*) (?:was|were) cancelled")


@dataclass(frozen=True, slots=True)
class Phase:
    """The time from one trigger to the next that concerns one of its robots."""

    stack: str
    start: float  # s, the trigger; of the first phase the run's first tick
    end: float  # s, the next trigger or the run's end; not part of it
    adopted: (
        float | None
    )  # s, when the controller took the stack over; None: never, or the first phase
    robots: tuple[str, ...] = ()  # that it is about; empty: all
    # adopted, cancelled, aborted, replaced (by the next request), under way; empty: the first phase
    outcome: str = field(default="", compare=False)

    @property
    def title(self) -> str:
        """The stack, and the robots unless it is about all of them."""
        return f"{self.stack} ({', '.join(self.robots)})" if self.robots else self.stack

    def ticks(self, time: Vector) -> NDArray[np.bool_]:
        """Return which of these times [s] lie in the phase."""
        slack = 1e-6  # stamps are rounded to nanoseconds
        return np.asarray((time >= self.start - slack) & (time < self.end - slack))


def find_phases(run: Run) -> tuple[Phase, ...]:
    """Return the phases: the first stack, then one for every switch that was triggered.

    A trigger is the first tick at which the source prepares the new stack or the blend runs:
    when a request that names a later tick takes effect.
    """
    first = float(run.plant.stamp[0])
    end = float(run.plant.stamp[-1]) + run.period
    stack = run.chi[COMMANDER].stack
    initial = str(stack[0]) if len(stack) else run.resolved.scenario.initial_stack
    starts = [Phase(initial, first, end, None), *_switches(run, end)]
    return tuple(
        _ended(phase, next((n.start for n in starts[i + 1 :] if _touch(phase, n)), None), end)
        for i, phase in enumerate(starts)
    )


def _ended(phase: Phase, replaced: float | None, end: float) -> Phase:
    """Return a phase with its end: when another one replaced it, or with the run at ``end``."""
    if replaced is None:
        return replace(phase, end=end)
    outcome = "replaced" if phase.outcome == "under way" else phase.outcome
    return replace(phase, end=replaced, outcome=outcome)


def _touch(one: Phase, other: Phase) -> bool:
    """Return whether two phases have a robot in common."""
    return not (one.robots and other.robots and set(one.robots).isdisjoint(other.robots))


def _switches(run: Run, end: float) -> list[Phase]:
    """Return every switch as a phase that lasts until ``end`` [s].

    A stack counts as adopted at the end of the blend, also where the controller stays with the
    source.
    """
    status = run.transition
    under_way = np.isin(status.phase, (TransitionPhase.PREPARING, TransitionPhase.BLENDING))
    switches, cancelled = [], cancelled_ids(run)
    for number in sorted(set(status.id[under_way].tolist())):
        mine = status.id == number
        trigger = int(np.flatnonzero(mine & under_way)[0])
        target = str(status.to_stack[trigger])
        arrived = mine & (status.to_stack == target) & (status.alpha >= 1.0)
        arrived &= status.phase != TransitionPhase.ABORTED
        adopted = float(status.stamp[arrived][0]) if arrived.any() else None
        names = str(status.robots[trigger]).split() if len(status.robots) else []
        robots = () if set(names) == set(run.robots) else tuple(names)
        aborted = bool((mine & (status.phase == TransitionPhase.ABORTED)).any())
        outcome = _outcome(number, cancelled, adopted=adopted is not None, aborted=aborted)
        start = float(status.stamp[trigger])
        switches.append(Phase(target, start, end, adopted, robots, outcome))
    # Numbers count requests; one that names a later tick may begin after its successor.
    return sorted(switches, key=lambda switch: switch.start)


def _outcome(number: int, cancelled: Collection[int], *, adopted: bool, aborted: bool) -> str:
    """Return what became of a switch, as far as its own messages tell."""
    if adopted:
        return "adopted"
    if number in cancelled:
        return "cancelled"
    return "aborted" if aborted else "under way"


def cancelled_ids(run: Run) -> frozenset[int]:
    """Return the numbers of the transitions that a user cancelled, as the controller says."""
    status = run.transition
    aborted = status.phase == TransitionPhase.ABORTED
    texts = [_CANCELLED.match(text) for text in set(status.reason[aborted].tolist())]
    return frozenset(
        int(number) for found in texts if found for number in found.group(1).split(", ")
    )


def tasks_of(run: Run, stack: str, types: frozenset[str]) -> dict[str, TaskConfig]:
    """Return a stack's task of one of these types, by robot; a robot without one is left out."""
    config = run.resolved.stacks.get(stack)
    levels = () if config is None else config.levels
    tasks = [task for level in levels for task in level.tasks if task.type in types]
    moved = (config.robots if config is not None else ()) or run.robots
    return {name: task for name in moved for task in tasks[::-1] if task.robot in ("", name)}


def held_objects(run: Run, stack: str) -> dict[str, str]:
    """Return who holds an object with whom: two tools whose references say how they stand."""
    tasks = tasks_of(run, stack, RELATIVE_TASKS)
    return {
        name: task.parameters["other"]
        for name, task in tasks.items()
        if "other" in task.parameters and _OF_OBJECTS.issuperset(task.parameters)
    }
