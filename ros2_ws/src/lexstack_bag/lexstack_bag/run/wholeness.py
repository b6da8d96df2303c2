"""What kept a run, or its bag, from being whole: braking, lost ticks, resets, gaps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lexstack_bag.figures.series import COMMANDER
from lexstack_bag.run.run import Integers, PlantStatus, Run

_FINEST = 1 / 2000  # of the run: gaps between bands that are shorter cannot be seen


@dataclass(frozen=True, slots=True)
class Wholeness:
    """What the plant and the bag say about ticks that are not as they should be.

    Attributes:
        late_ticks: that began after their wall-clock time, as the plant counted.
        missing_ticks: for which no command came in time, as the plant counted.
        holding_ticks: states in the bag with the status HOLDING.
        braking_ticks: states in the bag with the status BRAKING, up to the scenario's end: real
            robots are braked there.
        states_not_in_bag: ticks between the first and the last state whose state is not there.
        longest_gap_s: the longest time between two states with such ticks in between; 0: none.
        commands_not_in_bag: ticks from the first to the last command whose command is not there.
    """

    late_ticks: int
    missing_ticks: int
    holding_ticks: int
    braking_ticks: int
    states_not_in_bag: int
    longest_gap_s: float
    commands_not_in_bag: int


@dataclass(frozen=True, slots=True)
class Band:
    """A time in which the plant did not follow a command.

    Attributes:
        kind: "braking", or "holding" the last command.
        start: s.
        end: s.
    """

    kind: Literal["braking", "holding"]
    start: float
    end: float


def wholeness_of(run: Run) -> Wholeness:
    """Return what a run says about itself."""
    plant, command = run.plant, run.chi[COMMANDER]
    steps = np.diff(plant.stamp)[np.diff(plant.tick) > 1]
    in_time = plant.tick <= round(run.resolved.scenario.duration / run.period)
    return Wholeness(
        _counted(plant.late_ticks, run),
        _counted(plant.missing_ticks, run),
        int(np.count_nonzero(plant.status == PlantStatus.HOLDING)),
        int(np.count_nonzero(in_time & (plant.status == PlantStatus.BRAKING))),
        span_of(plant.tick) - len(plant.tick),
        round(float(steps.max(initial=0.0)), 9),
        span_of(command.tick) - len(command.tick),
    )


def doubts_of(run: Run, wholeness: Wholeness) -> tuple[str, ...]:
    """Return why no goal can be called reached, in words; empty where nothing forbids it."""
    found = []
    if wholeness.braking_ticks:
        found.append(f"the plant braked during {ticks_of(wholeness.braking_ticks)}")
    if wholeness.missing_ticks:
        found.append(f"the plant got no command in time in {ticks_of(wholeness.missing_ticks)}")
    if len(run.parts) > 1:
        found.append(f"the plant was reset: this is part {run.part} of {len(run.parts)} of the bag")
    return tuple(found)


def gaps_of(wholeness: Wholeness) -> tuple[str, ...]:
    """Return what the bag does not have, in words."""
    found = []
    if wholeness.states_not_in_bag:
        found.append(
            f"the states of {ticks_of(wholeness.states_not_in_bag)} are not in the bag (the "
            f"longest gap lasts {wholeness.longest_gap_s:.3g} s)"
        )
    if wholeness.commands_not_in_bag:
        found.append(
            f"the commands of {ticks_of(wholeness.commands_not_in_bag)} are not in the bag, so "
            "peaks may be missing"
        )
    return tuple(found)


def other_parts(run: Run) -> tuple[str, ...]:
    """Return what else a bag with resets holds, in words."""
    return tuple(
        f"part {number}: {part.states} states, {part.start_s:.2f} to {part.end_s:.2f} s"
        for number, part in enumerate(run.parts, 1)
        if number != run.part
    )


def ticks_of(count: int) -> str:
    """Return a number of ticks in words."""
    return f"{count} tick" if count == 1 else f"{count} ticks"


def bands_of(run: Run) -> tuple[Band, ...]:
    """Return the times in which the plant braked or held, in their order.

    The status of a state says what the plant did in the tick that led to it. Bands whose distance
    cannot be seen in a plot are drawn as one.
    """
    least = _FINEST * float(run.plant.stamp[-1] - run.plant.stamp[0])
    braking = list(_bands(run, PlantStatus.BRAKING, "braking", least))
    holding = list(_bands(run, PlantStatus.HOLDING, "holding", least))
    return tuple(sorted([*braking, *holding], key=lambda band: band.start))


def _bands(
    run: Run, status: PlantStatus, kind: Literal["braking", "holding"], least: float
) -> Iterator[Band]:
    """Yield the bands of one status; those nearer than ``least`` [s] to each other are one."""
    rows = np.flatnonzero(run.plant.status == status)
    if not len(rows):
        return
    ends = run.plant.stamp[rows]
    starts = ends - run.period
    neighbours = np.diff(rows) == 1  # also where states between them are not in the bag
    apart = (starts[1:] - ends[:-1] > max(least, 0.5 * run.period)) & ~neighbours
    first = np.concatenate([[0], np.flatnonzero(apart) + 1])
    last = np.concatenate([first[1:] - 1, [len(rows) - 1]])
    for begin, end in zip(starts[first].tolist(), ends[last].tolist(), strict=True):
        yield Band(kind, begin, end)


def span_of(ticks: Integers) -> int:
    """Return the number of ticks from the first to the last, missing ones as well."""
    return int(ticks[-1] - ticks[0]) + 1 if len(ticks) else 0


def _counted(counter: Integers, run: Run) -> int:
    """Return what a counter of the plant rose to; it goes on over a reset."""
    before = int(counter[0]) if run.part > 1 else 0
    return int(counter[-1]) - before
